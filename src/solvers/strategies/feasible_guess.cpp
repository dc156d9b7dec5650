#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "solvers/common/tuning.hpp"
#include "solvers/strategies/joined_solves.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

SolverOptions with_penalty(SolverOptions options, double factor) {
  auto& penalty = options.augmented_lagrangian;
  penalty.initial_penalty = std::min(factor * penalty.initial_penalty, penalty.max_penalty);
  return options;
}

/// True if a solver ended on its own or after all its iterations; other solves were stopped.
bool has_ended(SolveStatus status) {
  return is_success(status) || status == SolveStatus::infeasible ||
         status == SolveStatus::line_search_failed || status == SolveStatus::regularization_limit ||
         status == SolveStatus::max_iterations;
}

bool satisfies(double gap, double constraint, const SolverOptions::Tolerances& t) {
  return gap <= t.gap && constraint <= t.constraint;
}

/// First-order cost of closing the residual of an answer: an upper bound by the multipliers. Only
/// near feasibility, within the root of the tolerance, do multipliers say that much.
double price_of_residual(const SolveResult& result, const SolverOptions::Tolerances& t) {
  const Residuals& r = result.residuals;
  if (!satisfies(r.gap * r.gap, r.constraint * r.constraint, t))
    return std::numeric_limits<double>::infinity();
  return r.constraint * result.constraint_multipliers.lpNorm<1>() +
         r.gap * result.costates.lpNorm<1>();
}

bool is_worse(const SolveResult& result, const IterationRecord& guess,
              const SolverOptions::Tolerances& tolerances) {
  if (!has_ended(result.status)) return false;
  const bool feasible = satisfies(result.residuals.gap, result.residuals.constraint, tolerances);
  const double cost = result.cost + (feasible ? 0 : price_of_residual(result, tolerances));
  return !(cost <= guess.cost + tuning::kEqualCost * std::abs(guess.cost));
}

}  // namespace

SolverOptions options_near(const SolverOptions& options) {
  return with_penalty(options, tuning::kStronger * tuning::kStronger);
}

SolveResult solve_keeping_guess(const SolverOptions& options, const Trajectory& guess,
                                bool penalizes, const SolveFrom& solve) {
  JoinedSolves solves(options);
  SolveResult result = solve(solves.next(), guess);
  if (result.log.empty()) return result;
  const auto& t = options.tolerances;
  const IterationRecord first = result.log.front();
  if (!satisfies(first.gap, first.constraint, t) || !is_worse(result, first, t)) return result;
  const std::string before = fmt::format("from a feasible guess of cost {:.9g} to {}, cost {:.9g}",
                                         first.cost, to_string(result.status), result.cost);
  solves.add(result);
  for (const double factor : {tuning::kStronger, tuning::kStronger * tuning::kStronger}) {
    if (!penalizes || solves.iterations_left() <= 0) break;
    result = solve(with_penalty(solves.next(), factor), guess);
    solves.add(result);
    result.message = fmt::format("{}; with a larger penalty: {}", before, result.message);
    if (!is_worse(result, first, t)) return solves.answer(std::move(result));
  }
  const bool used_up = result.status == SolveStatus::max_iterations;
  SolverOptions own = solves.next();
  own.max_iterations = 0;
  result = solve(own, guess);
  solves.add(result);
  if (result.status != SolveStatus::converged)
    result.status = used_up ? SolveStatus::max_iterations : SolveStatus::line_search_failed;
  result.message = before + "; this is the guess";
  return solves.answer(std::move(result));
}

}  // namespace conddp
