#include "solvers/ddp_solver.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "ocp/checkpoint.hpp"
#include "ocp/stopwatch.hpp"
#include "solvers/finite_check.hpp"
#include "solvers/guess.hpp"

namespace conddp {
namespace {

/// Rows of the log that are reserved at most before the first iteration.
constexpr int kReservedRows = 10000;
/// The straight steps of an equality search close gaps no earlier than the solve ends. There exact
/// second derivatives wait until the gaps are this small.
constexpr double kNearlyClosed = 1e-3;
/// What a correction of a model step is taken to leave of the gaps before one has been seen.
constexpr double kFirstCorrection = 1;

}  // namespace

DdpSolver::DdpSolver(const ShootingProblem& problem, const DdpRecipe& recipe,
                     const SolverOptions& options)
    : problem_(problem),
      recipe_(recipe),
      options_(options),
      bounds_(problem),
      acts_(problem, options.threads),
      linearization_(problem),
      hessian_(recipe.hessian, options.tolerances.stationarity, acts_, linearization_),
      gaps_(problem),
      adjoint_(problem, bounds_),
      free_adjoint_(problem, bounds_),
      no_feedback_(problem),
      direction_(problem, bounds_,
                 {.clamp_controls = recipe.clamp_controls,
                  .box_stage = recipe.box_stage,
                  .null_space = recipe.multipliers == MultiplierSchedule::by_the_sweep &&
                                !problem.constraints().empty(),
                  .legs = {recipe.legs ? options.legs : 1, options.threads}},
                 options.box_qp),
      line_search_(problem, options.line_search),
      open_gap_search_(problem, bounds_, options.line_search, recipe.clamp_controls),
      model_step_(problem, bounds_),
      regularization_(options.regularization),
      trajectory_(problem.create_trajectory()),
      step_start_(problem.create_trajectory()),
      before_(problem.create_trajectory()),
      result_(problem) {
  if (!recipe.constraints || problem.constraints().empty()) return;
  constraints_.emplace(problem, options, recipe.multipliers);
  augmentation_ = &constraints_->augmentation();
  former_augmentation_.emplace(problem);
  augmentation_change_.emplace(problem);
  affine_probe_.emplace(problem);
  plain_adjoint_.emplace(problem, bounds_);
  if (direction_.null_space() != nullptr) equality_search_.emplace(problem, options.line_search);
  if (recipe.newton) newton_.emplace(problem, acts_);
}

SolveResult DdpSolver::solve(const Trajectory& guess) {
  began_ = std::chrono::steady_clock::now();
  check_shape(problem_, guess);
  result_ = SolveResult(problem_);
  result_.log.reserve(std::min(options_.max_iterations, kReservedRows) + 1);
  regularization_ = RegularizationSchedule(options_.regularization);
  row_ = IterationRecord();
  direction_.reset();
  line_search_.reset();
  open_gap_search_.reset();
  search_ = LineSearchResult();
  merit_ = MeritModel();
  linearized_ = differentiated_ = affine_known_ = false;
  stepping_ = abandoned_ = false;
  at_rounding_floor_ = false;
  full_steps_ = 0;
  full_steps_wanted_ = 1;
  first_look_suffices_ = false;
  correction_leaves_ = kFirstCorrection;
  hessian_.reset();
  start_constraints();

  if (start(guess)) {
    fit_penalties();
    iterate();
    finish();
  }
  result_.iterations = row_.iteration;
  result_.times.total = elapsed();
  return std::move(result_);
}

/// Iterations until one of them ends the solve, or a signal or the time limit ends one of them. The
/// first linearisation is never given up: without it there is nothing to say of the guess.
void DdpSolver::iterate() {
  const CheckpointScope scope([this] {
    if (!result_.log.empty() && !budget_left()) throw Abandoned();
  });
  try {
    while (linearize() && !converged() && may_continue() && (try_step() || recover()))
      ++row_.iteration;
  } catch (const Abandoned&) {
    abandoned_ = true;
    if (stepping_) trajectory_ = step_start_;
    linearized_ = differentiated_ = false;
    log_is_stale_ = true;
  }
}

/// Where the first iteration starts. With closed gaps the states follow from the controls.
bool DdpSolver::start(const Trajectory& guess) {
  trajectory_ = guess;
  result_.start = recipe_.open_gaps ? "states and controls of the guess"
                                    : "controls of the guess, simulated from the initial state";
  if (constraints_ && options_.multipliers) result_.start += "; its multipliers";
  if (recipe_.clamp_controls) result_.start += clamp_guess(bounds_, trajectory_);
  if (recipe_.open_gaps) {
    result_.start += correct_states(problem_, trajectory_);
    return true;
  }
  const Stopwatch watch(result_.times.evaluate);
  const int bad_knot = acts_.simulate(trajectory_);
  if (bad_knot < 0) return true;
  result_.trajectory = guess;
  result_.failed_knot = bad_knot;
  result_.failed_quantity = "cost or next state";
  return end(SolveStatus::diverged,
             fmt::format("simulating the controls of the guess gives a cost or next state that is "
                         "not finite at knot {}",
                         bad_knot));
}

/// Derivatives and residuals of the iterate, and its row in the log.
bool DdpSolver::linearize() {
  if (!linearized_) differentiate();
  if (!linearized_) return end_diverged();
  last_stationarity_ = row_.stationarity;
  measure_iterate();
  row_.time_s = elapsed();
  hessian_.watch(row_);
  result_.log.push_back(row_);
  log_is_stale_ = false;
  if (options_.on_iteration) options_.on_iteration(row_);
  return true;
}

/// Residuals and merit of the linearised iterate.
void DdpSolver::measure_iterate() {
  row_.cost = linearization_.total_cost() + soft_cost();
  merit_.cost = linearization_.total_cost();
  if (equality_search_) {
    merit_.gap_norm =
        equality_search_->infeasibility(linearization_.gap, linearization_.constraint);
  } else {
    merit_.cost += linearization_.augmentation.sum();
    merit_.gap_norm = gaps_.norm();
  }
  merit_.rounding = adjoint_.cost_rounding(linearization_, trajectory_);
  row_.merit = merit_.value();
  const Extremum stationarity = bounds_.projected_norm(adjoint_.gradient(), trajectory_);
  row_.stationarity = stationarity.value;
  row_.stationarity_knot = stationarity.knot;
  row_.gap = linearization_.max_gap();
  row_.gap_knot = -1;
  if (row_.gap > 0) {
    Eigen::Index row = 0, column = 0;
    linearization_.gap.cwiseAbs().maxCoeff(&row, &column);
    row_.gap_knot = static_cast<int>(column);
  }
  measure_constraints();
}

bool DdpSolver::converged() {
  const auto& tolerance = options_.tolerances;
  if (row_.stationarity <= stationarity_goal_ && row_.gap <= tolerance.gap &&
      row_.constraint <= tolerance.constraint &&
      row_.complementarity <= tolerance.complementarity && confirmed()) {
    end(SolveStatus::converged, residual_text());
    return true;
  }
  if (!constraints_ || direction_.null_space() != nullptr) return false;
  if (newton_converges()) {
    end(SolveStatus::converged, residual_text());
    return true;
  }
  if (!linearized_) return !end_diverged();
  return inner_converged() && !next_multipliers();
}

bool DdpSolver::may_continue() {
  if (row_.iteration >= options_.max_iterations) {
    return end(SolveStatus::max_iterations, fmt::format("not converged after {} iterations: {}",
                                                        row_.iteration, residual_text()));
  }
  return budget_left();
}

bool DdpSolver::budget_left() {
  if (options_.interrupted && options_.interrupted()) {
    return end(SolveStatus::interrupted, fmt::format("interrupted: {}", residual_text()));
  }
  if (elapsed() >= options_.max_time_s) {
    return end(SolveStatus::time_limit, "the time is up: " + residual_text());
  }
  return true;
}

/// Derivatives and co-states of the iterate; linearized_ tells whether they are finite.
void DdpSolver::differentiate() {
  const Stopwatch watch(result_.times.differentiate);
  hessian_.begin_iterate();
  if (!differentiated_) acts_.differentiate(trajectory_, linearization_, augmentation_);
  differentiated_ = false;
  gaps_.set(linearization_, recipe_.open_gaps);
  adjoint_.compute(linearization_, trajectory_, gaps_, direction_.feedback());
  linearized_ = std::isfinite(linearization_.total_cost()) &&
                std::isfinite(linearization_.augmentation.sum()) &&
                all_finite(linearization_.gap) && all_finite(adjoint_.costates()) &&
                all_finite(adjoint_.gradient());
  const double open = equality_search_ ? kNearlyClosed : options_.tolerances.gap;
  const bool closed = !recipe_.open_gaps || linearization_.max_gap() <= open;
  if (hessian_.exact_wanted() && linearized_ && closed) {
    hessian_.evaluate_exact(trajectory_, adjoint_.costates(), augmentation_);
  }
}

/// Residuals, co-states and gains of the iterate that is returned.
void DdpSolver::finish() {
  if (!linearized_) differentiate();
  result_.trajectory = trajectory_;
  if (find_non_finite(linearization_)) return;
  result_.cost = linearization_.total_cost() + soft_cost();
  Residuals& residuals = result_.residuals;
  const Extremum stationarity = bounds_.projected_norm(adjoint_.gradient(), trajectory_);
  residuals.stationarity = stationarity.value;
  residuals.stationarity_knot = stationarity.knot;
  residuals.gap = 0;
  for (int k = 0; k < problem_.knots(); ++k) {
    const double gap = linearization_.gap.col(k).lpNorm<Eigen::Infinity>();
    if (gap <= residuals.gap) continue;
    residuals.gap = gap;
    residuals.gap_knot = k;
  }
  measure_constraints();
  residuals.constraint = row_.constraint;
  residuals.constraint_knot = row_.constraint_knot;
  residuals.complementarity = row_.complementarity;
  result_.constraint_values = linearization_.constraint;
  if (constraints_) result_.constraint_multipliers = constraints_->multipliers();
  if (log_is_stale_) end_log();
  confirm_status();
  name_contradiction();
  result_.costates = adjoint_.costates();
  result_.state_gradient = adjoint_.state_gradient();
  for (int k = 0; k < problem_.knots(); ++k) {
    result_.control_gradient.push_back(
        adjoint_.gradient().segment(bounds_.offset(k), problem_.nu(k)));
  }
  if (by_newton_) {
    result_.feedback = newton_->feedback();
    result_.feedback_regularization = 0;
    return;
  }
  // Who waits for an iteration does not wait for its gains.
  if (!abandoned_) sweep_for_gains();
}

/// Makes the last row of the log that of the answer, where it was of a step that does not stand or
/// of other gains.
void DdpSolver::end_log() {
  IterationRecord row = row_;
  row.cost = result_.cost;
  row.stationarity = result_.residuals.stationarity;
  row.stationarity_knot = result_.residuals.stationarity_knot;
  row.gap = result_.residuals.gap;
  row.gap_knot = result_.residuals.gap_knot;
  row.step = row.expected_decrease = row.actual_decrease = 0;
  row.trials = row.sweeps = 0;
  row.time_s = result_.log.back().time_s;
  result_.log.back() = row;
}

/// The co-states of the last sweep may put an answer under tolerance that ended otherwise.
void DdpSolver::confirm_status() {
  const Residuals& r = result_.residuals;
  const auto& tolerance = options_.tolerances;
  if (r.stationarity > tolerance.stationarity || r.gap > tolerance.gap ||
      r.constraint > tolerance.constraint || r.complementarity > tolerance.complementarity) {
    return;
  }
  if (result_.status == SolveStatus::converged) return;
  result_.failed_knot = -1;
  result_.failed_quantity.clear();
  end(SolveStatus::converged,
      fmt::format("at the end, all residuals are under tolerance: stationarity {:.1e}, gap {:.1e}, "
                  "constraint violation {:.1e}",
                  r.stationarity, r.gap, r.constraint));
}

/// Without regularisation if possible: a follower of the trajectory wants the true gains.
void DdpSolver::sweep_for_gains() {
  const Stopwatch watch(result_.times.sweep);
  direction_.stay_at_iterate();
  SolverOptions::Regularization from_zero = options_.regularization;
  from_zero.initial = 0;
  RegularizationSchedule schedule(from_zero);
  do {
    if (sweep_backward(schedule.value()) < 0) {
      result_.feedback = direction_.feedback();
      result_.feedback_regularization = schedule.value();
      return;
    }
  } while (schedule.increase());
}

bool DdpSolver::end(SolveStatus status, std::string message) {
  result_.status = status;
  result_.message = std::move(message);
  return false;
}

bool DdpSolver::end_diverged() {
  const NonFinite where = find_non_finite(linearization_).value_or(NonFinite{0, "co-state"});
  const bool first = row_.iteration == 0;
  if (!first) trajectory_ = before_;
  linearized_ = false;
  result_.failed_knot = where.knot;
  result_.failed_quantity = where.quantity;
  return end(SolveStatus::diverged,
             fmt::format("the {} of knot {} is not finite {}", where.quantity, where.knot,
                         first ? "at the start" : "after the last step, which is taken back"));
}

std::string DdpSolver::residual_text() const {
  const auto at = [](int knot) { return knot < 0 ? "" : fmt::format(" (knot {})", knot); };
  std::string text =
      fmt::format("stationarity {:.1e}{}", row_.stationarity, at(row_.stationarity_knot));
  text += fmt::format(", gap {:.1e}{}", row_.gap, at(row_.gap_knot));
  text += fmt::format(", constraint violation {:.1e}", row_.constraint);
  if (constraints_) {
    text += at(row_.constraint_knot);
    text += fmt::format(", complementarity {:.1e}", row_.complementarity);
  }
  return text;
}

double DdpSolver::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

}  // namespace conddp
