#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "ocp/problem/violation_problem.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/constraints/violation_slope.hpp"
#include "solvers/ddp/ddp_solver.hpp"
#include "solvers/strategies/joined_solves.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

bool can_restore(const ShootingProblem& problem) {
  const auto& constraints = problem.constraints();
  return std::any_of(constraints.begin(), constraints.end(),
                     [](const NodeConstraint& c) { return !c.is_soft(); }) &&
         std::none_of(constraints.begin(), constraints.end(),
                      [](const NodeConstraint& c) { return c.term->has_pairs(); });
}

/// Changes the status of a solve whose violation is not proved to be the least.
void name_undecided(SolveResult& result) {
  if (result.status != SolveStatus::infeasible) return;
  result.status = SolveStatus::line_search_failed;
  result.message =
      "whether the constraints can be satisfied has not been decided: " + result.message;
}

bool has_feasible_iterate(const std::vector<IterationRecord>& log, const SolverOptions& options) {
  return std::ranges::any_of(log, [&](const IterationRecord& row) {
    return row.gap <= options.tolerances.gap && row.constraint <= options.tolerances.constraint;
  });
}

/// First penalty of the solve that continues from a restoration. Controls without bounds may have
/// to become large: under a smaller penalty than that of the restoration they fall back.
double penalty_after(const ShootingProblem& problem, const SolverOptions& options,
                     const SolveResult& stalled, const SolveResult& restored) {
  const double usual = next_first_penalty(options, stalled);
  if (problem.has_control_bounds()) return usual;
  return std::max(usual, std::min(restored.log.back().constraint_penalty,
                                  options.augmented_lagrangian.max_penalty));
}

/// True if the controls alone lead to a motion that is not much worse. States then follow from the
/// controls in every step, and the violation only falls.
bool can_simulate(const ShootingProblem& problem, const Trajectory& start) {
  Evaluator evaluator(problem, 1);
  const ControlBounds bounds(problem);
  Linearization linearization(problem);
  ViolationSlope slope(problem, bounds);
  Trajectory motion = start;
  const auto violation = [&] {
    evaluator.differentiate(motion, linearization);
    return slope.violation(linearization.constraint);
  };
  const double at_states = violation();
  bounds.clamp(motion);
  return evaluator.simulate(motion) < 0 && violation() <= tuning::kSimulated * at_states;
}

}  // namespace

bool got_stuck(const SolveResult& result, const SolverOptions& options) {
  switch (result.status) {
    case SolveStatus::infeasible:
      return true;
    case SolveStatus::line_search_failed:
    case SolveStatus::regularization_limit:
    case SolveStatus::diverged:
      return result.residuals.constraint > options.tolerances.constraint;
    default:
      return false;
  }
}

SolveResult restore_feasibility(const ShootingProblem& problem, const SolverOptions& options,
                                const Trajectory& start) {
  SolverOptions own = options;
  own.multipliers = nullptr;
  own.tolerances.cost_decrease = 0;
  DdpSolver solver(problem,
                   {.open_gaps = !can_simulate(problem, start),
                    .clamp_controls = true,
                    .box_stage = true,
                    .constraints = true,
                    .least_violation = true,
                    .hessian = HessianUse::when_slow},
                   own);
  solver.solve(start);
  return solver.take();
}

SolveResult solve_with_restoration(const ShootingProblem& problem, const SolverOptions& options,
                                   const Trajectory& guess, const SolveFrom& solve) {
  JoinedSolves solves(options);
  SolveResult result = solve(solves.next(), guess);
  if (!got_stuck(result, options)) return result;
  solves.add(result);
  std::string note;
  const int most = can_restore(problem) ? tuning::kRestorations : 0;
  for (int i = 1; i <= most && got_stuck(result, options) && solves.iterations_left() > 0; ++i) {
    note += fmt::format("stalled at iteration {}, restoration of feasibility; ",
                        options.max_iterations - solves.iterations_left());
    const auto mark = [i](IterationRecord& row) { row.restoration = i; };
    SolveResult restored = restore_feasibility(problem, solves.next(mark), result.trajectory);
    if (restored.log.empty()) {  // not even its first point is finite: the answer stays
      note += restored.message + "; ";
      break;
    }
    const double penalty = penalty_after(problem, options, result, restored);
    result = std::move(restored);
    solves.add(result);
    if (result.status != SolveStatus::converged) {
      result.message = note + result.message;
      return solves.answer(std::move(result));
    }
    SolverOptions own = solves.next();
    own.multipliers = nullptr;
    own.augmented_lagrangian.initial_penalty = penalty;
    result = solve(own, result.trajectory);
    solves.add(result);
  }
  name_undecided(result);
  result.message = note + result.message;
  return solves.answer(std::move(result));
}

SolveResult confirm_infeasible(
    const ShootingProblem& problem, const SolverOptions& options, SolveResult result,
    const Doubt& doubt, const SolveFrom& solve,
    const std::function<SolveResult(const ShootingProblem&, const Trajectory&)>& minimize) {
  if (result.status != SolveStatus::infeasible) return result;
  const ShootingProblem violation = violation_problem(problem);
  Evaluator evaluator(violation);
  Evaluation values(violation);
  const double before_s = result.times.total;
  JoinedSolves solves(options);
  solves.add(result);
  for (int i = 0; i < tuning::kRestorations && result.status == SolveStatus::infeasible; ++i) {
    const std::string objection = doubt ? doubt(problem, result).text : "";
    evaluator.evaluate(result.trajectory, values);
    const double before = values.cost.sum();
    const SolveResult least = minimize(violation, result.trajectory);
    const bool falls = least.cost < (1 - tuning::kRestored) * before;
    // If a certificate confirms a minimum, a slowly falling search need not converge.
    const bool searched =
        is_success(least.status) || (doubt && least.status == SolveStatus::max_iterations);
    if (!falls && searched && objection.empty()) break;
    if (!falls || i + 1 == tuning::kRestorations || solves.iterations_left() <= 0) {
      name_undecided(result);
      break;
    }
    SolverOptions own = solves.next();
    own.multipliers = nullptr;
    own.augmented_lagrangian.initial_penalty = next_first_penalty(options, result);
    SolveResult next = solve(own, least.trajectory);
    next.message =
        fmt::format("{}; from a motion with a smaller violation: {}", result.message, next.message);
    result = std::move(next);
    solves.add(result);
  }
  result = solves.answer(std::move(result));
  result.times.total += before_s;
  if (has_feasible_iterate(result.log, options)) name_undecided(result);
  return result;
}

}  // namespace conddp
