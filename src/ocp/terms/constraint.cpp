#include "ocp/terms/constraint.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace conddp {
namespace {

/// √(Σp²), bounded away from zero so that unselected lanes and their derivatives stay finite.
template <class S>
S length(const S* p, int n) {
  S sum(1e-200);
  for (int i = 0; i < n; ++i) sum += p[i] * p[i];
  return sqrt(sum);
}

std::vector<int> all_columns(const Residual& residual) {
  std::vector<int> columns;
  for (const RowBlock& block : residual.blocks())
    columns.insert(columns.end(), block.columns.begin(), block.columns.end());
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  return columns;
}

bool has_pairs_of_entries(const Residual& residual) {
  const auto is_entry = [](const RowBlock& b) { return b.rows == 1 && b.columns.size() == 1; };
  return residual.size() % 2 == 0 &&
         std::all_of(residual.blocks().begin(), residual.blocks().end(), is_entry);
}

/// Entries of blocks, each as (row, index among all columns).
std::vector<std::pair<int, int>> entries_of(const std::vector<RowBlock>& blocks,
                                            const std::vector<int>& columns) {
  std::vector<std::pair<int, int>> entries;
  int first_row = 0;
  for (const RowBlock& block : blocks) {
    for (const int column : block.columns) {
      const auto at = std::lower_bound(columns.begin(), columns.end(), column);
      for (int i = 0; i < block.rows; ++i)
        entries.emplace_back(first_row + i, static_cast<int>(at - columns.begin()));
    }
    first_row += block.rows;
  }
  return entries;
}

/// ‖v‖² of s = (v, t).
template <class S>
S tangential_square(const S* s, int n) {
  S sum(0.0);
  for (int i = 0; i + 1 < n; ++i) sum += s[i] * s[i];
  return sum;
}

/// √square, bounded away from zero so that unselected lanes and their derivatives stay finite.
template <class S>
S positive_root(const S& square) {
  return sqrt(max(square, S(1e-200)));
}

/// Throws std::invalid_argument if the residual does not fit the kind of the constraint.
void check_residual(const ConstraintTerm& term, const Residual& residual) {
  if (term.is_cone() && (residual.size() < 2 || !(term.slope > 0)))
    throw std::invalid_argument("constraint " + term.name +
                                ": a cone has two rows or more and a positive slope");
  if (term.has_pairs() && !has_pairs_of_entries(residual))
    throw std::invalid_argument("constraint " + term.name +
                                ": complementary rows are pairs of single columns");
}

}  // namespace

bool ConstraintTerm::depends_on_control(int ndx) const {
  return std::any_of(blocks.begin(), blocks.end(), [ndx](const RowBlock& block) {
    return !block.columns.empty() && block.columns.back() >= ndx;
  });
}

int ConstraintTerm::jacobian_size() const {
  return std::accumulate(blocks.begin(), blocks.end(), 0, [](int sum, const RowBlock& block) {
    return sum + block.rows * static_cast<int>(block.columns.size());
  });
}

ConstraintTerm make_constraint(std::string name, std::shared_ptr<const Residual> residual,
                               ConstraintKind kind, double slope, Softness softness) {
  ConstraintTerm term{.name = std::move(name), .kind = kind, .slope = slope, .softness = softness};
  check_residual(term, *residual);
  if (kind == ConstraintKind::bounds || kind == ConstraintKind::complementarity) {
    term.rows = residual->size();
    term.blocks = residual->blocks();
  } else {
    term.rows = kind == ConstraintKind::norm ? 1 : residual->size();
    term.blocks = {{term.rows, all_columns(*residual)}};
    term.entries = entries_of(residual->blocks(), term.blocks.front().columns);
  }
  term.residual = std::move(residual);
  return term;
}

template <class S>
void outside_cone(const S* s, int n, S* p) {
  const S t = s[n - 1], square = tangential_square(s, n), a = positive_root(square);
  const auto inside = square <= t * abs(t), polar = square <= -t * abs(t);
  const S half = S(0.5) * (S(1.0) - t / a);
  const S share = select(inside, S(0.0), select(polar, S(1.0), half));
  for (int i = 0; i + 1 < n; ++i) p[i] = share * s[i];
  p[n - 1] = select(inside, S(0.0), select(polar, t, -(half * a)));
}

template <class S>
void outside_cone_derivative(const S* s, int n, S* derivative) {
  const S t = s[n - 1], square = tangential_square(s, n);
  const S inverse = S(1.0) / positive_root(square);
  const auto inside = square <= t * abs(t), polar = square <= -t * abs(t);
  const auto pick = [&](const S& between, double identity) {
    return select(inside, S(0.0), select(polar, S(identity), between));
  };
  for (int j = 0; j + 1 < n; ++j) {
    for (int i = 0; i + 1 < n; ++i) {
      S entry = S(0.5) * t * inverse * (s[i] * inverse) * (s[j] * inverse);
      if (i == j) entry += S(0.5) * (S(1.0) - t * inverse);
      derivative[j * n + i] = pick(entry, i == j ? 1.0 : 0.0);
    }
    derivative[j * n + n - 1] = derivative[(n - 1) * n + j] = pick(-(S(0.5) * s[j] * inverse), 0.0);
  }
  derivative[n * n - 1] = pick(S(0.5), 1.0);
}

namespace {

/// The larger value, or NaN if one of them is NaN.
double larger_or_nan(double largest, double value) {
  return std::isnan(largest) || value <= largest ? largest : value;
}

/// |min(z, s)|, or NaN if one of them is NaN.
double pair_distance(double z, double s) {
  const bool first = !(z >= s) && !std::isnan(s);
  return std::abs(first ? z : s);
}

double cone_distance(const double* s, int n) {
  const double t = s[n - 1], a = std::sqrt(tangential_square(s, n));
  if (a <= t) return 0;
  return a <= -t ? std::hypot(a, t) : (a - t) * std::sqrt(0.5);
}

}  // namespace

double distance_to_set(const ConstraintTerm& term, const double* values, const double* lower,
                       const double* upper) {
  if (term.is_cone()) return cone_distance(values, term.rows);
  double largest = 0;
  if (term.has_pairs()) {
    for (int i = 0; i < term.rows; i += 2)
      largest = larger_or_nan(largest, pair_distance(values[i], values[i + 1]));
    return largest;
  }
  for (int i = 0; i < term.rows; ++i)
    largest = larger_or_nan(largest, std::abs(outside_bounds(values[i], lower[i], upper[i])));
  return largest;
}

double bound_complementarity(double value, double lower, double upper, double multiplier) {
  // The multiplier of an equality is free at any value; the deviation is a violation.
  if (multiplier == 0 || lower == upper) return 0;
  const double bound = multiplier > 0 ? upper : lower;
  const double inside = multiplier > 0 ? bound - value : value - bound;
  return std::isfinite(bound) ? std::abs(multiplier) * std::max(inside, 0.0) : std::abs(multiplier);
}

double distance_to_polar_cone(const double* multipliers, int n) {
  const double t = multipliers[n - 1], a = std::sqrt(tangential_square(multipliers, n));
  if (a <= -t) return 0;
  return a <= t ? std::hypot(a, t) : (a + t) * std::sqrt(0.5);
}

namespace {

double pair_complementarity(const double* values, const double* multipliers, int rows) {
  double largest = 0;
  for (int i = 0; i < rows; i += 2) {
    const int larger = values[i] > values[i + 1] ? i : i + 1;
    largest = std::max(largest, std::abs(multipliers[larger] * values[larger]));
  }
  return largest;
}

}  // namespace

double complementarity(const ConstraintTerm& term, const double* values, const double* lower,
                       const double* upper, const double* multipliers) {
  const int n = term.rows;
  if (term.is_cone()) {
    double product = 0;
    for (int i = 0; i < n; ++i) product += multipliers[i] * values[i];
    return std::max(std::abs(product), distance_to_polar_cone(multipliers, n));
  }
  if (term.has_pairs()) return pair_complementarity(values, multipliers, n);
  double largest = 0;
  for (int i = 0; i < n; ++i)
    largest =
        std::max(largest, bound_complementarity(values[i], lower[i], upper[i], multipliers[i]));
  return largest;
}

template <class S>
void limit_cone(int n, const S& limit, S* p) {
  const S a = length(p, n);
  const S share = select(a <= limit, S(1.0), limit / a);
  for (int i = 0; i < n; ++i) p[i] *= share;
}

template <class S>
void limit_cone_derivative(const S* p, int n, const S& limit, S* derivative) {
  const S a = length(p, n), share = limit / a, inverse = S(1.0) / a;
  const auto within = a <= limit;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      S& entry = derivative[j * n + i];
      entry = select(within, entry, share * (entry - (p[i] * inverse) * (p[j] * inverse)));
    }
}

#define CONDDP_INSTANTIATE(S)                               \
  template void outside_cone(const S*, int, S*);            \
  template void outside_cone_derivative(const S*, int, S*); \
  template void limit_cone(int, const S&, S*);              \
  template void limit_cone_derivative(const S*, int, const S&, S*);
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

double soft_distance(const ConstraintTerm& term, const double* g, const double* lower,
                     const double* upper, double power) {
  if (!term.has_bounds()) return std::pow(distance_to_set(term, g, lower, upper), power);
  double sum = 0;
  for (int i = 0; i < term.rows; ++i)
    sum += std::pow(std::abs(outside_bounds(g[i], lower[i], upper[i])), power);
  return sum;
}

double soft_cost(const ConstraintTerm& term, const double* g, const double* parameters,
                 double cost_scale) {
  if (term.softness == Softness::hard || parameters[term.active()] == 0) return 0;
  const double* lower = term.has_bounds() ? parameters + term.lower() : nullptr;
  const double* upper = term.has_bounds() ? parameters + term.upper() : nullptr;
  const double weight = cost_scale * parameters[term.weight()];
  return term.softness == Softness::l1 ? weight * soft_distance(term, g, lower, upper, 1)
                                       : 0.5 * weight * soft_distance(term, g, lower, upper, 2);
}

}  // namespace conddp
