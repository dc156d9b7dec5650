#include "solvers/strategies/scaled_solve.hpp"

#include <fmt/format.h>

#include "ocp/problem/cost_scale.hpp"

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

}  // namespace

SolveResult solve_scaled(
    const ShootingProblem& problem, const SolverOptions& options,
    const std::function<SolveResult(const ShootingProblem&, const SolverOptions&)>& solve) {
  const double scale = cost_scale(problem);
  if (scale == 1) return solve(problem, options);
  SolverOptions own = options;
  if (options.multipliers) own.multipliers = scaled(*options.multipliers, scale);
  if (options.on_iteration)
    own.on_iteration = [&](const IterationRecord& row) {
      options.on_iteration(unscaled(row, scale));
    };
  SolveResult result = solve(scale_costs(problem, scale), own);
  unscale(result, scale);
  return result;
}

}  // namespace conddp
