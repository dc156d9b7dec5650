#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/common/status.hpp"
#include "solvers/strategies/joined_solves.hpp"
#include "solvers/strategies/problem_units.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

IterationRecord unscaled(IterationRecord row, double scale) {
  for (double IterationRecord::*number :
       {&IterationRecord::cost, &IterationRecord::merit, &IterationRecord::stationarity,
        &IterationRecord::penalty, &IterationRecord::expected_decrease,
        &IterationRecord::actual_decrease})
    row.*number /= scale;
  return row;
}

void unscale(SolveResult& result, double scale) {
  result.message = fmt::format("with costs times {:.3g}: {}", scale, result.message);
  result.cost /= scale;
  result.residuals.stationarity /= scale;
  if (result.feedback_regularization) *result.feedback_regularization /= scale;
  result.costates /= scale;
  result.state_gradient /= scale;
  for (Eigen::VectorXd& gradient : result.control_gradient) gradient /= scale;
  result.constraint_multipliers /= scale;
  for (IterationRecord& row : result.log) row = unscaled(row, scale);
}

std::shared_ptr<const DualGuess> scaled(const DualGuess& guess, double scale) {
  DualGuess own = guess;
  own.constraints *= scale;
  own.costates *= scale;
  for (Eigen::VectorXd& gradient : own.control_gradient) gradient *= scale;
  return std::make_shared<const DualGuess>(std::move(own));
}

SolveResult solve_with_costs(const ShootingProblem& problem, double scale,
                             const SolverOptions& options, const Trajectory& guess,
                             const SolveProblem& solve) {
  if (scale == 1) return solve(problem, options, guess);
  SolverOptions own = options;
  if (options.multipliers) own.multipliers = scaled(*options.multipliers, scale);
  if (options.on_iteration)
    own.on_iteration = [&](const IterationRecord& row) {
      options.on_iteration(unscaled(row, scale));
    };
  SolveResult result = solve(scale_costs(problem, scale), own, guess);
  unscale(result, scale);
  return result;
}

/// True if all residuals of an answer are within tolerance.
bool is_converged(const SolveResult& result, const SolverOptions::Tolerances& tolerances) {
  const Residuals& r = result.residuals;
  return r.stationarity <= tolerances.stationarity && r.gap <= tolerances.gap &&
         r.constraint <= tolerances.constraint && r.complementarity <= tolerances.complementarity;
}

/// Judges an answer in the problem's own units. Rounding may hide the accuracy that the scaled
/// problem requests, or leave more than its tolerances allow.
void judge(const SolverOptions::Tolerances& tolerances, SolveResult& result) {
  const bool converged = is_converged(result, tolerances);
  if (converged && result.status == SolveStatus::line_search_failed) {
    result.status = SolveStatus::converged;
    result.message += "; all residuals are under tolerance in the problem's units";
    result.failed_knot = -1;
    result.failed_quantity.clear();
  } else if (!converged && result.status == SolveStatus::converged) {
    result.status = SolveStatus::line_search_failed;
    result.message += "; not all residuals are under tolerance in the problem's units";
  }
}

/// Converts states, controls and rows. Costs are scaled elsewhere.
class Units {
 public:
  Units(const ShootingProblem& problem, const ProblemUnits& units)
      : problem_(problem),
        units_(units),
        state_(Eigen::Map<const Eigen::VectorXd>(units.state.data(), problem.nx())),
        row_(Eigen::VectorXd::Ones(problem.constraint_rows())) {
    for (int k = 0; k <= problem.knots(); ++k) {
      const auto& rows = units.at(problem, k).row_factors;
      row_.segment(problem.constraint_offset(k), rows.size()) = vector(rows);
    }
  }

  Trajectory scaled(Trajectory motion) const {
    for (int k = 0; k <= problem_.knots(); ++k) motion.x(k).array() /= state_.array();
    for (int k = 0; k < problem_.knots(); ++k) motion.u(k).array() /= control(k).array();
    return motion;
  }

  std::shared_ptr<const DualGuess> scaled(const DualGuess& guess) const {
    DualGuess own = guess;
    own.constraints.array() /= row_.array();
    if (own.costates.size() > 0) own.costates.array().colwise() *= state_.array();
    for (std::size_t k = 0; k < own.control_gradient.size(); ++k)
      own.control_gradient[k].array() *= control(static_cast<int>(k)).array();
    return std::make_shared<const DualGuess>(std::move(own));
  }

  /// Tolerances under which an answer meets the given ones in the problem's units.
  SolverOptions::Tolerances scaled(SolverOptions::Tolerances tolerances) const {
    tolerances.gap /= std::max(1.0, state_.maxCoeff());
    if (row_.size() > 0) tolerances.constraint *= std::min(1.0, row_.minCoeff());
    double least = 1;
    for (int k = 0; k < problem_.knots(); ++k)
      if (problem_.nu(k) > 0) least = std::min(least, control(k).minCoeff());
    tolerances.stationarity *= least * std::min(1.0, units_.cost);
    return tolerances;
  }

  void unscale(SolveResult& result) const {
    result.message =
        fmt::format("in units of {:.3g} to {:.3g}: {}", least(), largest(), result.message);
    for (int k = 0; k <= problem_.knots(); ++k) {
      result.trajectory.x(k).array() *= state_.array();
      result.costates.col(k).array() /= state_.array();
      result.state_gradient.col(k).array() /= state_.array();
    }
    for (int k = 0; k < problem_.knots(); ++k) {
      result.trajectory.u(k).array() *= control(k).array();
      result.feedback.k[k].array() *= control(k).array();
      result.feedback.K[k] =
          control(k).asDiagonal() * result.feedback.K[k] * state_.cwiseInverse().asDiagonal();
    }
    for (std::size_t k = 0; k < result.control_gradient.size(); ++k)
      result.control_gradient[k].array() /= control(static_cast<int>(k)).array();
    // The regularization is proportional to other units: the gains would belong to no sweep.
    if (result.feedback_regularization.value_or(0) > 0) {
      result.feedback.set_zero();
      result.feedback_regularization.reset();
    }
    result.constraint_values.array() /= row_.array();
    result.constraint_multipliers.array() *= row_.array();
    // In costs of the usual size, as without units.
    const double of_costs = cost_scale(problem_) / units_.cost;
    result.residuals.complementarity *= of_costs;
    for (IterationRecord& row : result.log) row.complementarity *= of_costs;
    measure(result);
  }

 private:
  static Eigen::Map<const Eigen::VectorXd> vector(const std::vector<double>& numbers) {
    return {numbers.data(), static_cast<Eigen::Index>(numbers.size())};
  }
  Eigen::Map<const Eigen::VectorXd> control(int k) const {
    return vector(units_.at(problem_, k).control);
  }
  double least() const {
    double least = state_.minCoeff();
    for (int k = 0; k < problem_.knots(); ++k)
      if (problem_.nu(k) > 0) least = std::min(least, control(k).minCoeff());
    return least;
  }
  double largest() const {
    double largest = state_.maxCoeff();
    for (int k = 0; k < problem_.knots(); ++k)
      if (problem_.nu(k) > 0) largest = std::max(largest, control(k).maxCoeff());
    return largest;
  }

  /// Measures residuals in the problem's units, also in the last row of the log; the first row gets
  /// bounds on them.
  void measure(SolveResult& result) const {
    const ControlBounds bounds(problem_);
    Evaluation at(problem_);
    Evaluator(problem_).evaluate(result.trajectory, at);
    Residuals& residuals = result.residuals;
    if (at.gap.size() > 0) residuals.gap = at.gap.cwiseAbs().maxCoeff();
    residuals.constraint =
        largest_violation(problem_, bounds, result.trajectory, at.constraint).value;
    Eigen::VectorXd gradient(bounds.size());
    for (std::size_t k = 0; k < result.control_gradient.size(); ++k)
      gradient.segment(bounds.offset(static_cast<int>(k)), result.control_gradient[k].size()) =
          result.control_gradient[k];
    residuals.stationarity = bounds.projected_norm(gradient, result.trajectory).value;
    if (result.log.empty()) return;
    IterationRecord &first = result.log.front(), &last = result.log.back();
    first.gap *= std::max(1.0, state_.maxCoeff());
    if (row_.size() > 0) first.constraint /= std::min(1.0, row_.minCoeff());
    last.gap = residuals.gap;
    last.constraint = residuals.constraint;
    last.stationarity = residuals.stationarity;
  }

  const ShootingProblem& problem_;
  const ProblemUnits& units_;
  const Eigen::VectorXd state_;
  Eigen::VectorXd row_;
};

SolveResult solve_in_units(const ShootingProblem& problem, const ProblemUnits& of_problem,
                           const SolverOptions& options, const Trajectory& guess,
                           const SolveProblem& solve) {
  const Units units(problem, of_problem);
  const ShootingProblem scaled = in_units(problem, of_problem);
  JoinedSolves solves(options);
  const auto solve_to = [&](const SolverOptions::Tolerances& tolerances, const DualGuess* duals,
                            const Trajectory& from) {
    SolverOptions own = solves.next();
    own.tolerances = tolerances;
    own.multipliers = duals ? units.scaled(*duals) : nullptr;
    SolveResult result = solve_with_costs(scaled, of_problem.cost, own, units.scaled(from), solve);
    units.unscale(result);
    solves.add(result);
    return result;
  };
  SolveResult result = solve_to(options.tolerances, options.multipliers.get(), guess);
  if (result.status == SolveStatus::converged && !is_converged(result, options.tolerances)) {
    const DualGuess duals{result.constraint_multipliers, result.costates, result.control_gradient};
    result = solve_to(units.scaled(options.tolerances), &duals, result.trajectory);
  }
  judge(options.tolerances, result);
  return solves.answer(std::move(result));
}

}  // namespace

SolveResult solve_scaled(const ShootingProblem& problem, const SolverOptions& options,
                         const Trajectory& guess, const SolveProblem& solve) {
  const auto units = units_of(problem, guess);
  const auto solve_by = [&](bool in_other_units, const SolverOptions& own) {
    return in_other_units ? solve_in_units(problem, *units, own, guess, solve)
                          : solve_with_costs(problem, cost_scale(problem), own, guess, solve);
  };
  if (!units) return solve_by(false, options);
  JoinedSolves solves(options);
  SolveResult first = solve_by(units->far_apart, solves.next());
  solves.add(first);
  const int most = SolverOptions().max_iterations;
  const bool stopped =
      first.status == SolveStatus::time_limit || first.status == SolveStatus::interrupted;
  if (is_success(first.status) || stopped ||
      (options.max_iterations < most && solves.iterations_left() <= 0))
    return first;
  SolverOptions own = solves.next();
  if (options.max_iterations >= most) own.max_iterations = options.max_iterations;
  SolveResult other = solve_by(!units->far_apart, own);
  const std::string ended =
      fmt::format("{} after {} iterations", to_string(first.status), first.iterations);
  if (!is_success(other.status)) {
    first.message += fmt::format("; in other units {}", to_string(other.status));
    first.times.total = solves.seconds();
    return first;
  }
  other.message = fmt::format("{}; in other units: {}", ended, other.message);
  solves.add(other);
  return solves.answer(std::move(other));
}

}  // namespace conddp
