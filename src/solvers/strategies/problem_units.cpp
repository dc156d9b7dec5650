#include "solvers/strategies/problem_units.hpp"

#include <algorithm>
#include <cmath>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

double power_of_two(double size) {
  if (!(size > 0)) return 1;
  return std::exp2(
      std::round(std::clamp(std::log2(size), -tuning::kMostSizes, tuning::kMostSizes)));
}

/// True if all sizes are within a range of binary logarithms. An unknown size (0) always is.
bool are_within(const std::vector<double>& sizes, double least, double largest) {
  return std::ranges::all_of(sizes, [&](double size) {
    return size == 0 || (std::log2(size) >= least && std::log2(size) <= largest);
  });
}

/// True if the binary logarithms of all sizes are within a range. Rows may have large derivatives:
/// their remaining violation is small.
bool are_within(const ProblemUnits& units, double range) {
  return are_within(units.state, -range, range) &&
         std::ranges::all_of(units.models, [range](const auto& model) {
           return are_within(model.second.control, -range, range) &&
                  are_within(model.second.row_factors, -range, tuning::kMostSizes);
         });
}

void meet(double value, double& size) {
  if (std::isfinite(value)) size = std::max(size, std::abs(value));
}

bool has_fixed_units(const KnotModel& model) {
  const bool pairs = std::ranges::any_of(
      model.constraints(), [](const ConstraintTerm& term) { return term.has_pairs(); });
  return pairs || model.semi_implicit() || model.nx() != model.ndx() ||
         !model.manifold().curved().empty();
}

bool has_factors(const ConstraintTerm& term) {
  return term.softness == Softness::hard && !term.has_pairs();
}

class UnitFinder {
 public:
  UnitFinder(const ShootingProblem& problem, const Trajectory& guess)
      : problem_(problem), guess_(guess), linearization_(problem) {
    units_.state.assign(problem.nx(), 0.0);
    for (int k = 0; k <= problem.knots(); ++k) {
      const KnotModel& model = *problem.knot(k).model;
      units_.models[&model] = {std::vector<double>(model.nu(), 0.0),
                               std::vector<double>(model.constraint_rows(), 0.0)};
    }
  }

  std::optional<ProblemUnits> find() {
    Evaluator(problem_).differentiate(guess_, linearization_);
    if (!std::isfinite(linearization_.total_cost()) || !linearization_.constraint.allFinite())
      return std::nullopt;
    find_sizes();
    const ProblemUnits known = units_;
    round();
    units_.far_apart = !are_within(units_, tuning::kFarSizes);
    if (!units_.far_apart) {
      units_ = known;
      meet_responses();
      round();
      if (are_within(units_, tuning::kUsualSizes)) return std::nullopt;
    }
    for (auto& [model, own] : units_.models)
      for (double& factor : own.row_factors) factor = 1 / power_of_two(factor);
    find_cost();
    return std::move(units_);
  }

 private:
  ProblemUnits::OfModel& at(int k) { return units_.models.at(problem_.knot(k).model); }
  /// Unit of a column of z.
  double& unit(int k, int column) {
    const int n = problem_.ndx();
    return column < n ? units_.state[column] : at(k).control[column - n];
  }

  /// Takes sizes from rows that depend on one column only.
  void meet_rows(const NodeConstraint& c, bool equalities) {
    for (int r = 0; r < c.term->rows; ++r) {
      if ((c.lower[r] == c.upper[r]) != equalities) continue;
      const auto C =
          linearization_.knots[c.node].C.row(c.row + r - problem_.constraint_offset(c.node));
      Eigen::Index column = 0;
      const double slope = C.cwiseAbs().maxCoeff(&column);
      if (!(slope > 0) || (C.array() != 0).count() > 1) continue;
      double& size = unit(c.node, static_cast<int>(column));
      if (!equalities && size > 0) continue;
      const double z = column < problem_.ndx() ? guess_.x(c.node)[column]
                                               : guess_.u(c.node)[column - problem_.ndx()];
      for (const double bound : {c.lower[r], c.upper[r]}) {
        const double way = (bound - linearization_.constraint[c.row + r]) / C[column];
        if (std::abs(z + way) > tuning::kExact * std::max(1.0, std::abs(z))) meet(z + way, size);
      }
    }
  }

  /// Equalities and the guess come first: other bounds may be far away. Guesses are often zero, or
  /// nearly zero: sizes below 1 come from constraints only.
  void find_sizes() {
    for (const NodeConstraint& c : problem_.constraints())
      if (c.term->has_bounds()) meet_rows(c, true);
    for (int k = 0; k <= problem_.knots(); ++k) {
      for (int i = 0; i < problem_.nx(); ++i) meet_guess(guess_.x(k)[i], units_.state[i]);
      for (int i = 0; i < problem_.nu(k); ++i) meet_guess(guess_.u(k)[i], at(k).control[i]);
    }
    for (int k = 0; k < problem_.knots(); ++k) {
      const KnotModel& model = *problem_.knot(k).model;
      for (int i = 0; i < model.nu(); ++i)
        for (const double bound : {model.control_lower()[i], model.control_upper()[i]})
          meet(bound, at(k).control[i]);
    }
    for (const NodeConstraint& c : problem_.constraints())
      if (c.term->has_bounds()) meet_rows(c, false);
  }

  static void meet_guess(double value, double& size) {
    if (size > 0 || std::abs(value) >= 1) meet(value, size);
  }

  /// Finds the sizes that are unknown so far, to first order. A control is as large as a constant
  /// one that moves some state by its size. A state is as large as its response to the controls.
  void meet_responses() {
    int most = 0;
    for (const auto& [model, own] : units_.models) most = std::max(most, model->nu());
    std::vector<Eigen::VectorXd> responses;
    for (int i = 0; i < most; ++i) responses.push_back(response(i));
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(problem_.ndx());
    for (int i = 0; i < most; ++i) {
      double share = 0;
      for (int r = 0; r < moved.size(); ++r)
        if (units_.state[r] > 0) share = std::max(share, responses[i][r] / units_.state[r]);
      for (auto& [model, own] : units_.models) {
        if (i >= model->nu()) continue;
        if (own.control[i] == 0 && share > 0) own.control[i] = 1 / share;
        moved = moved.cwiseMax(responses[i] * own.control[i]);
      }
    }
    for (int r = 0; r < moved.size(); ++r)
      if (units_.state[r] == 0) units_.state[r] = moved[r];
  }

  /// Largest change of each state under a constant control of 1; 0 if it is unbounded.
  Eigen::VectorXd response(int control) {
    Eigen::VectorXd dx = Eigen::VectorXd::Zero(problem_.ndx()), next = dx, largest = dx, z;
    for (int k = 0; k < problem_.knots(); ++k) {
      z = Eigen::VectorXd::Zero(problem_.ndx() + problem_.nu(k));
      z.head(dx.size()) = dx;
      if (control < problem_.nu(k)) z[dx.size() + control] = 1;
      linearization_.knots[k].apply(z, next);
      dx.swap(next);
      largest = largest.cwiseMax(dx.cwiseAbs());
    }
    if (!largest.allFinite()) largest.setZero();
    return largest;
  }

  /// Rounds sizes to powers of two, and finds the sizes of rows from them.
  void round() {
    const auto round_all = [](std::vector<double>& sizes) {
      for (double& size : sizes) size = power_of_two(size);
    };
    round_all(units_.state);
    for (auto& [model, own] : units_.models) round_all(own.control);
    for (const NodeConstraint& c : problem_.constraints())
      if (has_factors(*c.term)) meet_factors(c);
  }

  /// The largest row of a cone determines all its rows.
  void meet_factors(const NodeConstraint& c) {
    const int first = c.row - problem_.constraint_offset(c.node);
    const auto C = linearization_.knots[c.node].C.middleRows(first, c.term->rows);
    double* size = &at(c.node).row_factors[first];
    double largest = 0;
    for (int r = 0; r < c.term->rows; ++r) {
      for (int i = 0; i < C.cols(); ++i) meet(C(r, i) * unit(c.node, i), size[r]);
      largest = std::max(largest, size[r]);
    }
    if (c.term->is_cone()) std::fill_n(size, c.term->rows, largest);
  }

  /// Finds the change of the costs if all variables move by their units; scaled by it, multipliers
  /// are about 1.
  void find_cost() {
    double sum = 0;
    for (int k = 0; k <= problem_.knots(); ++k) {
      const KnotLinearization& knot = linearization_.knots[k];
      double size = 0;
      for (int i = 0; i < knot.gradient.size(); ++i) {
        meet(knot.gradient[i] * unit(k, i), size);
        meet(knot.hessian()(i, i) * unit(k, i) * unit(k, i), size);
      }
      sum += size;
    }
    units_.cost = 1 / power_of_two(sum);
  }

  const ShootingProblem& problem_;
  const Trajectory& guess_;
  Linearization linearization_;
  ProblemUnits units_;
};

/// Multiplies factors with those already present.
std::vector<double> product(std::vector<double> factors, const std::vector<double>& present) {
  for (std::size_t i = 0; i < present.size(); ++i) factors[i] *= present[i];
  return factors;
}

std::shared_ptr<const KnotModel> in_units(const KnotModel& of, const ProblemUnits& units) {
  auto model = std::make_shared<KnotModel>(of);
  const ProblemUnits::OfModel& own = units.models.at(&of);
  std::vector<double> lower = of.control_lower(), upper = of.control_upper();
  for (int i = 0; i < of.nu(); ++i) {
    lower[i] /= own.control[i];
    upper[i] /= own.control[i];
  }
  model->set_control_bounds(std::move(lower), std::move(upper));
  model->set_units(
      {product(units.state, of.units().state), product(own.control, of.units().control)});
  for (std::size_t i = 0; i < of.constraints().size(); ++i) {
    const ConstraintTerm& term = of.constraints()[i];
    if (!has_factors(term)) continue;
    const auto first = own.row_factors.begin() + term.row;
    model->set_row_factors(i, product({first, first + term.rows}, term.row_factors));
  }
  return model;
}

/// A phase with a model in units; its bounds of rows are scaled as the rows are.
Phase in_units(const Phase& of, const std::vector<double>& factors,
               std::shared_ptr<const KnotModel> model) {
  Phase phase = of;
  phase.model = std::move(model);
  const int count = of.model->parameter_count();
  for (const ConstraintTerm& term : phase.model->constraints()) {
    if (!term.has_bounds() || !has_factors(term)) continue;
    for (int k = 0; k < phase.knots(); ++k)
      for (int r = 0; r < term.rows; ++r)
        for (const int bound : {term.lower(), term.upper()})
          phase.parameters[k * count + bound + r] *= factors[term.row + r];
  }
  return phase;
}

}  // namespace

std::optional<ProblemUnits> units_of(const ShootingProblem& problem, const Trajectory& guess) {
  if (problem.constraints().empty()) return std::nullopt;
  for (int k = 0; k <= problem.knots(); ++k)
    if (has_fixed_units(*problem.knot(k).model)) return std::nullopt;
  return UnitFinder(problem, guess).find();
}

ShootingProblem in_units(const ShootingProblem& problem, const ProblemUnits& units) {
  std::map<const KnotModel*, std::shared_ptr<const KnotModel>> models;
  const auto converted = [&](const Phase& phase) {
    auto& model = models[phase.model.get()];
    if (!model) model = in_units(*phase.model, units);
    return in_units(phase, units.models.at(phase.model.get()).row_factors, model);
  };
  std::vector<double> initial = problem.initial_state();
  for (std::size_t i = 0; i < initial.size(); ++i) initial[i] /= units.state[i];
  std::vector<Phase> phases;
  for (const Phase& phase : problem.phases()) phases.push_back(converted(phase));
  return ShootingProblem(std::move(initial), std::move(phases), converted(problem.terminal()));
}

}  // namespace conddp
