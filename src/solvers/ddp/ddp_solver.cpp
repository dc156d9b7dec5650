#include "solvers/ddp/ddp_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "base/stopwatch.hpp"
#include "ocp/evaluation/checkpoint.hpp"
#include "ocp/evaluation/evaluation_memory.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "solvers/common/feasible.hpp"
#include "solvers/common/finite_check.hpp"
#include "solvers/common/guess.hpp"
#include "solvers/common/settled_cost.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/linalg/exchange.hpp"

namespace conddp {
namespace {

/// Resolves the use of Hessians from the options if the recipe leaves it open.
DdpRecipe resolved(DdpRecipe recipe, const SolverOptions& options, const ShootingProblem& problem) {
  recipe.hessian = hessian_use(recipe.hessian, options, problem);
  return recipe;
}

std::unique_ptr<OuterStrategy> make_outer(const ShootingProblem& problem,
                                          const ControlBounds& bounds, const DdpRecipe& recipe,
                                          const SolverOptions& options, bool constrained) {
  if (!constrained) return std::make_unique<OuterStrategy>();
  if (recipe.least_violation) return least_violation_strategy(problem, bounds, options);
  return augmented_lagrangian_strategy(problem, options, recipe.multipliers);
}

}  // namespace

DdpSolver::DdpSolver(const ShootingProblem& problem, const DdpRecipe& recipe,
                     const SolverOptions& options, std::shared_ptr<EvaluationMemory> memory)
    : problem_(problem),
      recipe_(resolved(recipe, options, problem)),
      options_(options),
      constrained_(recipe.constraints && !problem.constraints().empty()),
      bounds_(problem),
      evaluator_(problem,
                 memory ? std::move(memory) : std::make_shared<EvaluationMemory>(options.threads)),
      record_(problem, options_, constrained_),
      iterate_(problem, bounds_, evaluator_, recipe_, options_, record_),
      outer_(make_outer(problem, bounds_, recipe_, options_, constrained_)),
      globalization_(problem, bounds_, recipe_, options_, iterate_, *outer_, record_),
      check_(problem, bounds_, options_, constrained_),
      answer_(problem),
      step_start_(problem.create_trajectory()) {
  if (constrained_ && recipe.newton) polish_.emplace(problem, evaluator_, options_);
  if (globalization_.rule().keeps_equalities())
    iterate_.exact_below = std::max(iterate_.exact_below, tuning::kNearlyClosed);
}

void DdpSolver::exchange_memory(DdpSolver& other) {
  iterate_.linearization.exchange(problem_, other.iterate_.linearization, other.problem_);
  globalization_.exchange_memory(other.globalization_);
  exchange(record_.result.feedback.K, other.record_.result.feedback.K);
}

const SolveResult& DdpSolver::solve(const Trajectory& guess, LastIterate last) {
  check_shape(problem_, guess);
  record_.begin();
  iterate_.reset();
  globalization_.reset(last == LastIterate::evaluated
                           ? tuning::kRealTimeSweeps * options_.max_iterations
                           : std::numeric_limits<int>::max());
  check_.reset();
  if (polish_) polish_->reset();
  stepping_ = abandoned_ = by_newton_ = evaluated_ = false;
  last_step_ = last == LastIterate::evaluated;
  outer_->start(options_.multipliers.get());
  if (start(guess)) {
    iterate();
    evaluated_ ? end_evaluated() : finish();
  }
  return record_.finished();
}

/// Sets the first iterate. With closed gaps, the states follow from the controls.
bool DdpSolver::start(const Trajectory& guess) {
  SolveResult& result = record_.result;
  iterate_.trajectory = guess;
  result.start = recipe_.open_gaps ? "states and controls of the guess"
                                   : "controls of the guess, simulated from the initial state";
  if (constrained_ && options_.multipliers) result.start += "; its multipliers";
  if (recipe_.clamp_controls) clamp_guess(bounds_, iterate_.trajectory, result.start);
  if (recipe_.open_gaps) {
    correct_states(problem_, iterate_.trajectory, result.start);
    return true;
  }
  const Stopwatch watch(result.times.evaluate);
  const int bad_knot = evaluator_.simulate(iterate_.trajectory);
  return bad_knot < 0 || end_at_guess(guess, bad_knot);
}

/// Ends the solve of a guess whose controls lead to values that are not finite.
bool DdpSolver::end_at_guess(const Trajectory& guess, int bad_knot) {
  SolveResult& result = record_.result;
  result.trajectory = guess;
  Evaluation at_guess(problem_);
  evaluator_.evaluate(guess, at_guess);
  result.constraint_values = at_guess.constraint;
  result.failed_knot = bad_knot;
  result.failed_quantity = "cost or next state";
  return record_.end(SolveStatus::diverged,
                     fmt::format("simulating the controls of the guess gives a cost or next state "
                                 "that is not finite at knot {}",
                                 bad_knot));
}

/// Iterates until an iteration ends the solve, or a signal or the time limit interrupts it. The
/// first linearization is never interrupted: without it nothing can be reported about the guess.
void DdpSolver::iterate() {
  const CheckpointScope scope([this] {
    if (!record_.result.log.empty() && !record_.budget_left()) throw Abandoned();
  });
  if (constrained_) fit_outer();
  try {
    while (run_iteration()) {
      ++record_.row.iteration;
      if (ends_by_last_step()) break;
    }
  } catch (const Abandoned&) {
    abandoned_ = true;
    if (stepping_) iterate_.trajectory = step_start_;
    iterate_.linearized = iterate_.differentiated = false;
    record_.log_is_stale = true;
  }
}

/// False if the iteration ends the solve.
bool DdpSolver::run_iteration() { return linearize() && !ends() && goes_on() && step(); }

/// Ends a solve at the iteration limit before the last iterate is linearized, if the caller wants
/// that. Without constraints, the result of a rollout is known already. An iterate that is not
/// finite is left to the linearization.
bool DdpSolver::ends_by_last_step() {
  if (!last_step_ || iterate_.linearized || record_.row.iteration < options_.max_iterations)
    return false;
  IterationRecord& row = record_.row;
  if (const LineSearchResult& found = globalization_.rule().found();
      found.rollout_cost && !constrained_) {
    row.cost = *found.rollout_cost;
    row.gap *= 1 - found.step;
  } else {
    const Stopwatch watch(record_.result.times.evaluate);
    evaluator_.evaluate(iterate_.trajectory, answer_);
    if (!std::isfinite(answer_.cost.sum()) || !all_finite(answer_.gap) ||
        !all_finite(answer_.constraint))
      return false;
    Eigen::Index entry = 0, knot = 0;
    iterate_.linearization.constraint = answer_.constraint;
    row.cost = answer_.cost.sum() + outer_->soft_cost(iterate_);
    row.gap = answer_.gap.cwiseAbs().maxCoeff(&entry, &knot);
    row.gap_knot = static_cast<int>(knot);
  }
  if (!(row.gap > 0)) row.gap_knot = -1;
  evaluated_ = true;
  return true;
}

/// Reports cost and residuals of an iterate that was not linearized, the policy that led to it, and
/// the multipliers that follow from the values of its constraints.
void DdpSolver::end_evaluated() {
  SolveResult& result = record_.result;
  IterationRecord& row = record_.row;
  result.cost = row.cost;
  outer_->measure(iterate_, row);
  outer_->take_multipliers();
  if (constrained_) result.constraint_multipliers = *outer_->multipliers();
  record_.log_row();
  record_.end(SolveStatus::max_iterations, "ended after {} iterations: {}", row.iteration,
              record_.residual_text());
  result.trajectory = iterate_.trajectory;
  record_.write_residuals();
  globalization_.take_feedback(result.feedback);
  result.feedback_regularization = row.regularization;
}

/// Shows the first iterate to the outer strategy, which may change the minimized function.
void DdpSolver::fit_outer() {
  iterate_.differentiate(globalization_.feedback(), outer_->augmentation());
  if (iterate_.linearized && outer_->fit(iterate_)) iterate_.linearized = false;
}

/// True if the linearized iterate, or Newton's method started from it, ends the solve.
bool DdpSolver::ends() {
  return (converged() && confirm()) || cost_settled() ||
         (polish_ && !last_step_ && polish_->due(record_.row) && polish());
}

/// True if something is left to minimize and iterations remain. The multipliers of a real-time
/// iteration already follow from its guess.
bool DdpSolver::goes_on() {
  if (!(last_step_ && record_.row.iteration == 0) &&
      outer_->minimized(record_.row, globalization_.rule().merit()) && !next_minimization())
    return false;
  return record_.may_continue();
}

/// Computes the derivatives and residuals of the iterate and logs its row.
bool DdpSolver::linearize() {
  if (!iterate_.linearized)
    iterate_.differentiate(globalization_.feedback(), outer_->augmentation());
  if (!iterate_.linearized) return iterate_.end_diverged();
  measure();
  iterate_.hessian.watch(record_.row);
  record_.log_row();
  return true;
}

/// Computes the residuals and the merit of the linearized iterate.
void DdpSolver::measure() {
  record_.row.cost = iterate_.linearization.total_cost() + outer_->soft_cost(iterate_);
  globalization_.rule().measure();
  iterate_.describe(record_.row);
  outer_->measure(iterate_, record_.row);
}

/// True if other gains and a Newton step can confirm the stationarity of an answer.
bool DdpSolver::is_confirmable() const {
  return !recipe_.least_violation && !globalization_.rule().keeps_equalities();
}

bool DdpSolver::converged() const {
  return outer_->solved(record_.row, options_.tolerances, check_.goal());
}

/// Ends the solve if stationarity also holds along other gains and almost nothing is left to gain.
bool DdpSolver::confirm() {
  if (is_confirmable() && !(check_.confirm(iterate_, outer_->multipliers()) &&
                            (constrained_ || check_.confirm_gain(iterate_, share_left()))))
    return false;
  record_.end(SolveStatus::converged, record_.residual_text());
  return true;
}

/// Share of the cost that a Newton step would gain. It is 0 after a full Newton step that gained
/// little, since such a step leaves even less.
double DdpSolver::share_left() {
  const IterationRecord& row = record_.row;
  const bool by_newton = row.iteration > 0 && row.step == 1 && row.regularization == 0;
  const auto gained_little = [&](double cost) {
    return by_newton && row.actual_decrease <= tuning::kMostGain * cost;
  };
  if (gained_little(std::abs(row.cost))) return 0;
  const double cost = std::max(std::abs(row.cost), least_cost(problem_));
  return gained_little(cost) ? 0 : globalization_.newton_gain() / cost;
}

/// Ends the solve if the iterate is feasible and the cost has settled as the caller requires.
bool DdpSolver::cost_settled() {
  const auto& tolerances = options_.tolerances;
  if (!cost_has_settled(record_.result.log, tolerances.cost_decrease) ||
      !outer_->solved(record_.row, tolerances, std::numeric_limits<double>::infinity()))
    return false;
  record_.end(SolveStatus::cost_settled, "the cost has settled: {}", record_.residual_text());
  return true;
}

/// Tries to end the solve by Newton's method. If only its multipliers fail the tests, minimization
/// continues from Newton's iterate.
bool DdpSolver::polish() {
  if (!polish_->run(iterate_, globalization_.feedback(), *outer_, record_)) return false;
  iterate_.differentiate(globalization_.feedback(), outer_->augmentation());
  if (!iterate_.linearized) return !iterate_.end_diverged();
  measure();
  record_.result.log.back() = record_.row;  // along the gains of the last sweep, as the answer is
  by_newton_ = record_.row.stationarity <= options_.tolerances.stationarity &&
               record_.row.complementarity <= options_.tolerances.complementarity &&
               check_.confirm(iterate_, outer_->multipliers());
  if (by_newton_) record_.end(SolveStatus::converged, record_.residual_text());
  return by_newton_;
}

/// Begins the next minimization at the same iterate. False if the solve ends.
bool DdpSolver::next_minimization() {
  if (!outer_->update(iterate_, globalization_.feedback(), globalization_.rule().merit(),
                      globalization_.rule().at_rounding_floor(), record_))
    return false;
  if (!iterate_.linearized) return iterate_.end_diverged();
  globalization_.begin_minimization();
  record_.row.stationarity = iterate_.stationarity().value;
  return true;
}

/// Takes a step that can be interrupted. If it finds none, another minimization may find one.
bool DdpSolver::step() {
  step_start_ = iterate_.trajectory;
  stepping_ = true;
  const bool taken = globalization_.step();
  stepping_ = false;
  return taken || (outer_->recovers(record_, globalization_.rule().at_rounding_floor()) &&
                   next_minimization());
}

/// Computes the residuals, co-states and gains of the returned iterate.
void DdpSolver::finish() {
  if (!iterate_.linearized)
    iterate_.differentiate(globalization_.feedback(), outer_->augmentation());
  SolveResult& result = record_.result;
  const bool finite = !find_non_finite(iterate_.linearization);
  // A non-finite derivative can leave costs and co-states finite.
  if (!finite && is_success(result.status)) iterate_.end_diverged();
  result.trajectory = iterate_.trajectory;
  result.constraint_values = iterate_.linearization.constraint;
  if (!finite) return;
  result.cost = iterate_.linearization.total_cost() + outer_->soft_cost(iterate_);
  iterate_.describe(record_.row);
  outer_->measure(iterate_, record_.row);
  replace_costates();
  record_.write_residuals();
  if (constrained_) result.constraint_multipliers = *outer_->multipliers();
  end_log();
  confirm_status();
  name_contradiction();
  result.costates = iterate_.adjoint.costates();
  result.state_gradient = iterate_.adjoint.state_gradient();
  std::vector<Eigen::VectorXd>& gradient = record_.control_gradient();
  for (int k = 0; k < problem_.knots(); ++k)
    gradient[k] = iterate_.adjoint.gradient().segment(bounds_.offset(k), problem_.nu(k));
  find_gains();
}

/// Replaces the co-states of a stationary answer by those along other gains if stiff gains have
/// distorted them.
void DdpSolver::replace_costates() {
  if (recipe_.least_violation || globalization_.rule().keeps_equalities() ||
      !outer_->solved(record_.row, options_.tolerances, options_.tolerances.stationarity))
    return;
  const Adjoint* better = check_.better(iterate_, outer_->multipliers());
  if (better == nullptr) return;
  iterate_.adjoint = *better;
  iterate_.describe(record_.row);
  outer_->measure(iterate_, record_.row);
  record_.log_is_stale = true;
}

/// Makes the last row of the log describe the answer. The row may belong to a rejected step, and a
/// sweep without a step may have changed the gains. The log is empty if the guess lacks finite
/// co-states.
void DdpSolver::end_log() {
  if (record_.result.log.empty()) return;
  IterationRecord& last = record_.result.log.back();
  if (!record_.log_is_stale) {
    last.stationarity = record_.row.stationarity;
    last.stationarity_knot = record_.row.stationarity_knot;
    last.complementarity = record_.row.complementarity;
    return;
  }
  const double time = last.time_s;
  last = record_.row;
  last.cost = record_.result.cost;
  last.step = last.expected_decrease = last.actual_decrease = 0;
  last.trials = last.sweeps = 0;
  last.time_s = time;
}

/// Changes the status to converged if the co-states of the last sweep bring all residuals under
/// tolerance. This requires that little is left to gain: a loop that ended before its goal had a
/// reason to continue.
void DdpSolver::confirm_status() {
  SolveResult& result = record_.result;
  const Residuals& r = result.residuals;
  const auto& tolerance = options_.tolerances;
  if (!(r.stationarity <= tolerance.stationarity) || !is_feasible(r, tolerance)) return;
  if (result.status == SolveStatus::converged) return;
  if (is_confirmable() && !constrained_ && share_left() > tuning::kMostGainAtEnd) return;
  result.failed_knot = -1;
  result.failed_quantity.clear();
  record_.end(SolveStatus::converged,
              "at the end, all residuals are under tolerance: stationarity {:.1e}, gap {:.1e}, "
              "constraint violation {:.1e}",
              r.stationarity, r.gap, r.constraint);
}

/// Reports contradictory equalities as the reason why a solve that enforces them did not converge.
void DdpSolver::name_contradiction() {
  const SolveStatus status = record_.result.status;
  if (status == SolveStatus::converged || status == SolveStatus::interrupted ||
      status == SolveStatus::time_limit)
    return;
  const double off = globalization_.contradiction();
  if (!(off > options_.tolerances.constraint)) return;
  record_.end(SolveStatus::infeasible,
              fmt::format("the linearized equality constraints contradict each other by {:.1e}: {}",
                          off, record_.residual_text()));
}

/// Recomputes the gains without regularization if possible, except in real-time iterations. Exact
/// Hessians use the co-states of the answer, which sweeps may have changed since.
void DdpSolver::find_gains() {
  SolveResult& result = record_.result;
  if (by_newton_) {
    result.feedback = polish_->feedback();
    result.feedback_regularization = 0;
    return;
  }
  if (abandoned_) return;
  if (last_step_ && result.status == SolveStatus::max_iterations && record_.row.iteration > 0) {
    result.feedback_regularization = record_.row.regularization;
  } else {
    iterate_.hessian.follow(iterate_.trajectory, iterate_.adjoint.costates(),
                            outer_->augmentation());
    result.feedback_regularization = globalization_.find_gains();
  }
  if (result.feedback_regularization) globalization_.take_feedback(result.feedback);
}

}  // namespace conddp
