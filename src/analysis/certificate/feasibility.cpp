#include "analysis/certificate/feasibility.hpp"

#include <algorithm>
#include <limits>

namespace conddp {
namespace {

/// A multiplier may exceed its limit or leave its normal cone by this share: rounding.
constexpr double kLimitRounding = 1e-10;

/// Entries of Worst that stand for constraints: −2 for the first, then downward.
int entry_of(int constraint) { return -2 - constraint; }

void meet_control_bounds(const ShootingProblem& problem, const SolutionClaims& claims, int k,
                         Feasibility& found) {
  const KnotModel& model = *problem.knot(k).model;
  for (int i = 0; i < problem.nu(k); ++i) {
    const double u = claims.trajectory.u(k)[i];
    for (const bool upper : {false, true}) {
      const double bound = upper ? model.control_upper()[i] : model.control_lower()[i];
      const double z = (upper ? claims.upper_multipliers : claims.lower_multipliers)[k][i];
      found.negative.meet(-z, 0, k, i);
      if (std::isfinite(bound)) {
        const double outside = upper ? u - bound : bound - u;
        found.violation.meet(outside, std::abs(bound), k, i);
        found.product.meet(std::abs(z * outside), std::abs(z) * std::max(1.0, std::abs(bound)), k,
                           i);
      } else if (z != 0) {
        found.product.meet(std::numeric_limits<double>::infinity(), 0, k, i);
      }
    }
  }
}

/// Soft constraint: its multiplier stays within the limit. If the constraint is violated, the part
/// of the multiplier that pushes back equals the limit.
void meet_limit(const NodeConstraint& c, double outside, double pushing, double size, int entry,
                Feasibility& found) {
  found.product.meet(outside * std::abs(c.limit - pushing), c.limit * std::max(1.0, outside),
                     c.node, entry);
  if (size > (1 + kLimitRounding) * c.limit) found.negative.meet(size - c.limit, 0, c.node, entry);
}

/// The multiplier of row i belongs to the bound selected by its sign, which must be finite.
void meet_multiplier(const NodeConstraint& c, int i, double g, double nu, int entry,
                     Feasibility& found) {
  const double bound = nu > 0 ? c.upper[i] : c.lower[i];
  const double inside = nu > 0 ? bound - g : g - bound;
  if (std::isfinite(bound))
    found.product.meet(std::abs(nu) * std::max(0.0, inside),
                       std::abs(nu) * std::max(1.0, std::abs(bound)), c.node, entry);
  else
    found.negative.meet(std::abs(nu), 0, c.node, entry);
}

void meet_rows(const NodeConstraint& c, const double* g, const double* nu, int entry,
               Feasibility& found) {
  for (int i = 0; i < c.term->rows; ++i) {
    const double above = g[i] - c.upper[i], below = c.lower[i] - g[i];
    if (c.is_soft())
      meet_limit(c, std::max({above, below, 0.0}), above > 0 ? nu[i] : -nu[i], std::abs(nu[i]),
                 entry, found);
    else
      found.violation.meet(std::max(below, above), std::abs(g[i]), c.node, entry);
    if (nu[i] != 0 && c.lower[i] != c.upper[i]) meet_multiplier(c, i, g[i], nu[i], entry, found);
  }
}

void meet_cone(const NodeConstraint& c, const double* g, const double* nu, int entry,
               Feasibility& found) {
  const Eigen::Map<const Eigen::VectorXd> value(g, c.term->rows), multiplier(nu, c.term->rows);
  const double outside = beyond_cone(value).norm();
  if (!c.is_soft()) {
    found.violation.meet(outside, value.lpNorm<1>(), c.node, entry);
  } else if (multiplier.norm() > (1 + kLimitRounding) * c.limit) {
    found.negative.meet(multiplier.norm() - c.limit, 0, c.node, entry);
  }
  const double paid = c.is_soft() ? c.limit * outside : 0;
  found.product.meet(std::abs(value.dot(multiplier) - paid),
                     value.cwiseAbs().dot(multiplier.cwiseAbs()) + paid, c.node, entry);
  const double off = beyond_cone(-multiplier).norm();
  if (off > kLimitRounding * multiplier.norm()) found.negative.meet(off, 0, c.node, entry);
}

/// Pairs (z, s): the smaller entry must vanish and may have any multiplier; the multiplier of the
/// larger one must vanish. If both are equal, the second counts as larger, as in the solvers.
void meet_pairs(const NodeConstraint& c, const double* g, const double* nu, int entry,
                Feasibility& found) {
  for (int i = 0; i < c.term->rows; i += 2) {
    const int smaller = g[i] <= g[i + 1] ? i : i + 1, larger = 2 * i + 1 - smaller;
    found.violation.meet(std::abs(g[smaller]), std::abs(g[larger]), c.node, entry);
    found.product.meet(std::abs(nu[larger] * g[larger]), std::abs(nu[larger]), c.node, entry);
  }
}

}  // namespace

Eigen::VectorXd beyond_cone(const Eigen::VectorXd& s) {
  const Eigen::Index n = s.size() - 1;
  const double v = s.head(n).norm(), t = s[n];
  if (v <= t) return Eigen::VectorXd::Zero(n + 1);
  if (v <= -t) return s;
  Eigen::VectorXd d(n + 1);
  d.head(n) = s.head(n) * (0.5 * (v - t) / v);
  d[n] = -0.5 * (v - t);
  return d;
}

Feasibility measure_feasibility(const ShootingProblem& problem, const SolutionClaims& claims,
                                const Eigen::VectorXd& values) {
  Feasibility found;
  for (int k = 0; k < problem.knots(); ++k) meet_control_bounds(problem, claims, k, found);
  for (std::size_t i = 0; i < problem.constraints().size(); ++i) {
    const NodeConstraint& c = problem.constraints()[i];
    const auto meet = c.term->is_cone() ? meet_cone : c.term->has_pairs() ? meet_pairs : meet_rows;
    meet(c, values.data() + c.row, claims.multipliers.data() + c.row, entry_of(static_cast<int>(i)),
         found);
  }
  return found;
}

int constraint_of(const Worst& worst) { return worst.entry > -2 ? -1 : -2 - worst.entry; }

}  // namespace conddp
