#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "ocp/soft_constraint.hpp"
#include "ocp/stopwatch.hpp"
#include "solvers/ddp_solver.hpp"
#include "solvers/finite_check.hpp"

namespace conddp {
namespace {

/// Minimisations of an augmented Lagrangian end early: at a stationarity and a relative decrease of
/// the merit that get smaller from one to the next.
constexpr double kFirstInnerTolerance = 1e-1, kFirstInnerDecrease = 1e-3;
/// A short step's small decrease says nothing.
constexpr double kLongStep = 0.1;
/// How often penalties may be lowered because of rounding.
constexpr int kRelaxations = 20;
/// Minimisations that may end without a step before the solve does.
constexpr int kRecoveries = 20;
constexpr double kTighter = 0.1, kLastInnerDecrease = 1e-8;
/// A minimisation that was asked for this share of the stationarity's tolerance, and ends above the
/// tolerance though the constraints hold, is stopped by rounding.
constexpr double kHopelessGoal = 1e-6;
/// How many times what new multipliers gain a step may gain in a minimisation that is done.
constexpr double kDualShare = 10;
/// Where the stationarity is not confirmed: the share of what should be enough that is asked for,
/// and of the tolerance at least.
constexpr double kGoalMargin = 0.5, kLeastGoal = 1e-5;
/// How much larger a gradient without gains may be and still counts.
constexpr double kMostAmplified = kGoalMargin / kLeastGoal;
/// Violation, gap and stationarity below which the projected Newton method is tried, how much
/// smaller they have to be after it failed, and its steps at most.
constexpr double kFirstNewtonThreshold = 3e-3, kNextNewtonThreshold = 0.1;
constexpr int kNewtonSteps = 20, kDampedNewtonSteps = 2;
constexpr double kNewtonGoal = 1e-12;

}  // namespace

/// Before a solve: the first penalties, and multipliers where there are some to start from.
void DdpSolver::start_constraints() {
  inner_tolerance_ = kFirstInnerTolerance;
  inner_decrease_ = kFirstInnerDecrease;
  inner_start_ = recoveries_ = relaxations_ = 0;
  newton_threshold_ = kFirstNewtonThreshold;
  by_newton_ = log_is_stale_ = false;
  stationarity_goal_ = options_.tolerances.stationarity;
  if (!constraints_) return;
  const bool known = options_.multipliers != nullptr;
  constraints_->start(known ? options_.multipliers->constraints : result_.constraint_multipliers);
}

/// At the first iterate, of which the derivatives then belong to the penalties that fit.
void DdpSolver::fit_penalties() {
  if (!constraints_) return;
  differentiate();
  if (linearized_ && constraints_->fit_soft(linearization_.constraint)) linearized_ = false;
}

/// What constraints that are soft by their distance cost, which no act knows of.
double DdpSolver::soft_cost() const {
  return constraints_ ? linear_soft_cost(problem_, linearization_.constraint) : 0;
}

void DdpSolver::measure_constraints() {
  const Extremum bounds = bounds_.violation(trajectory_);
  row_.constraint = bounds.value;
  row_.constraint_knot = bounds.knot;
  if (!constraints_) return;
  const ConstraintNorms norms = constraints_->measure(linearization_.constraint);
  if (!(norms.violation.value <= row_.constraint)) {
    row_.constraint = norms.violation.value;
    row_.constraint_knot = norms.violation.knot;
  }
  row_.complementarity = norms.complementarity;
  dual_gain_ = norms.dual_gain;
  row_.constraint_penalty = constraints_->largest_penalty();
}

/// Whether the augmented Lagrangian is minimised well enough for better multipliers.
bool DdpSolver::inner_converged() const {
  if (row_.gap > std::max(options_.tolerances.gap, 1e-2 * row_.constraint)) return false;
  if (row_.stationarity <= std::max(inner_tolerance_, options_.tolerances.stationarity))
    return true;
  return row_.iteration > inner_start_ && row_.step >= kLongStep &&
         row_.actual_decrease <= inner_decrease_ * std::abs(merit_.cost);
}

/// Whether the minimisation that has ended left no more to gain than other multipliers will. One
/// that ended early because its steps gain little may still be dominated by them: then violations
/// are its own, and say nothing against the penalties.
bool DdpSolver::minimized() const {
  return row_.stationarity <= std::max(inner_tolerance_, options_.tolerances.stationarity) ||
         row_.actual_decrease <= kDualShare * dual_gain_ || merit_.hidden(row_.actual_decrease);
}

/// Whether multipliers and penalties have done their work, and what is left of the stationarity is
/// rounding: ρ times that of the constraints' values.
bool DdpSolver::hidden_by_rounding() const {
  const auto& tolerance = options_.tolerances;
  if (row_.constraint > tolerance.constraint || row_.gap > tolerance.gap ||
      row_.complementarity > tolerance.complementarity)
    return false;
  return at_rounding_floor_ ||
         (inner_tolerance_ <= tolerance.stationarity && merit_.hidden(row_.actual_decrease)) ||
         inner_tolerance_ <= kHopelessGoal * tolerance.stationarity;
}

/// Ends a minimisation of the augmented Lagrangian and begins the next at the same iterate. False
/// where the solve ends.
bool DdpSolver::next_multipliers() {
  const bool idle = constraints_->idle(linearization_.constraint);
  const bool by_rounding = hidden_by_rounding();
  *former_augmentation_ = *augmentation_;
  constraints_->update(minimized());
  if (by_rounding) {
    if (++relaxations_ > kRelaxations) {
      linearized_ = false;
      result_.failed_quantity = kRoundedCost;
      return end(SolveStatus::line_search_failed,
                 fmt::format("rounding hides what is left of the stationarity, whatever the "
                             "penalties of the constraints: {}",
                             residual_text()));
    }
    constraints_->relax();
    inner_tolerance_ = std::max(inner_tolerance_, options_.tolerances.stationarity);
  }
  if (!constraints_->hopeless().empty()) {
    linearized_ = false;  // what is written belongs to the last multipliers
    return end(SolveStatus::infeasible,
               fmt::format("the constraint '{}' is violated whatever its penalty: {}",
                           constraints_->hopeless(), residual_text()));
  }
  ++row_.outer;
  inner_tolerance_ *= kTighter;
  inner_decrease_ = std::max(kTighter * inner_decrease_, kLastInnerDecrease);
  inner_start_ = row_.iteration;
  at_rounding_floor_ = false;
  regularization_ = RegularizationSchedule(options_.regularization);
  // As long as all rows are strictly inside of their sets they have no derivatives to change.
  if (!linearized_ || !(idle && constraints_->idle(linearization_.constraint))) {
    // Relaxed penalties are to have their own rounding.
    if (linearized_ && !by_rounding && !hessian_.exact_wanted())
      change_augmentation();
    else
      differentiate();
  }
  if (!linearized_) return end_diverged();
  merit_.cost = linearization_.total_cost() + linearization_.augmentation.sum();
  row_.stationarity = bounds_.projected_norm(adjoint_.gradient(), trajectory_).value;
  return true;
}

/// The derivatives of the iterate, known with the former augmentation, with the present one.
void DdpSolver::change_augmentation() {
  const Stopwatch watch(result_.times.differentiate);
  if (!augmentation_change_->apply(*former_augmentation_, *augmentation_, linearization_)) return;
  adjoint_.compute(linearization_, trajectory_, gaps_, direction_.feedback());
  linearized_ = std::isfinite(linearization_.augmentation.sum()) &&
                all_finite(adjoint_.costates()) && all_finite(adjoint_.gradient());
}

/// Equalities that contradict each other are why a solve that keeps them did not converge.
void DdpSolver::name_contradiction() {
  if (direction_.null_space() == nullptr || result_.status == SolveStatus::converged ||
      result_.status == SolveStatus::interrupted || result_.status == SolveStatus::time_limit)
    return;
  const double off = direction_.null_space()->contradiction();
  if (!(off > options_.tolerances.constraint)) return;
  end(SolveStatus::infeasible,
      fmt::format("the linearised equality constraints contradict each other by {:.1e}: {}", off,
                  residual_text()));
}

/// Where a minimisation gets no further, other multipliers and penalties may: by rounding, lower
/// ones.
bool DdpSolver::recover() {
  const bool stuck = result_.status == SolveStatus::line_search_failed ||
                     result_.status == SolveStatus::regularization_limit;
  if (!constraints_ || direction_.null_space() != nullptr || !stuck) return false;
  const bool by_rounding = at_rounding_floor_ && constraints_->may_relax();
  if (row_.constraint <= options_.tolerances.constraint && !by_rounding) return false;
  return ++recoveries_ <= kRecoveries && next_multipliers();
}

/// Whether a stationarity under tolerance is so along other gains, too: those of the costs alone
/// where constraints have stiff ones, else none. If it is not, the goal is what should be enough
/// then.
bool DdpSolver::confirmed() {
  const double tolerance = options_.tolerances.stationarity;
  if (equality_search_ || stationarity_goal_ <= kLeastGoal * tolerance) return true;
  const std::optional<double> found =
      plain_adjoint_
          ? plain_adjoint_->stationarity(acts_, trajectory_, gaps_, options_.regularization,
                                         constraints_->multipliers())
          : reduced_stationarity();
  if (!found || !(*found > tolerance)) return true;
  stationarity_goal_ =
      std::max(kGoalMargin * row_.stationarity * tolerance / *found, kLeastGoal * tolerance);
  return false;
}

/// ‖∇_u L‖∞ without gains, the gradient of the cost as a function of the controls alone. None where
/// open-loop dynamics amplify the residual too much: there it is ill-conditioned.
std::optional<double> DdpSolver::reduced_stationarity() {
  free_adjoint_.compute(linearization_, trajectory_, gaps_, no_feedback_);
  const double found = bounds_.projected_norm(free_adjoint_.gradient(), trajectory_).value;
  if (!(found <= kMostAmplified * row_.stationarity)) return std::nullopt;
  return found;
}

/// Tries to end the solve by Newton's method on the active constraints. Its steps are iterations.
/// Where they do not meet the tolerances the iterate before them stands; where only its
/// multipliers do not, minimisation goes on from Newton's iterate.
bool DdpSolver::newton_converges() {
  if (!newton_ || std::max({row_.stationarity, row_.gap, row_.constraint}) > newton_threshold_)
    return false;
  const IterationRecord row = row_;
  newton_->start(trajectory_, constraints_->multipliers(), augmentation_->penalty,
                 direction_.feedback());
  const auto& tolerance = options_.tolerances;
  int damped = 0;
  for (int i = 0; i < kNewtonSteps && row_.iteration < options_.max_iterations; ++i) {
    if (newton_->norms().largest() <= kNewtonGoal || !newton_->step()) break;
    ++row_.iteration;
    ++row_.newton;
    newton_->describe(row_);
    row_.time_s = elapsed();
    result_.log.push_back(row_);
    log_is_stale_ = true;  // until the iterate stands
    if (options_.on_iteration) options_.on_iteration(row_);
    damped += newton_->step_length() < 1;
    if (damped > kDampedNewtonSteps) break;
  }
  newton_threshold_ = kNextNewtonThreshold * std::max({row.stationarity, row.gap, row.constraint});
  // Multipliers of an iterate from which no step was found are no better than those that are there,
  // and begin again with the first penalties.
  const bool stands = row_.iteration == row.iteration &&
                      newton_->norms().complementarity > tolerance.complementarity;
  if (stands || newton_->norms().stationarity.value > tolerance.stationarity ||
      newton_->norms().gap.value > tolerance.gap ||
      newton_->norms().violation.value > tolerance.constraint) {
    const int iteration = row_.iteration;
    const int newton = row_.newton;
    row_ = row;
    row_.iteration = iteration;
    row_.newton = newton;
    return false;
  }
  before_ = trajectory_;
  trajectory_ = newton_->trajectory();
  log_is_stale_ = false;
  constraints_->adopt(newton_->multipliers());
  differentiate();
  if (!linearized_) return false;
  measure_iterate();
  result_.log.back() = row_;  // along the gains of the last sweep, as the answer is
  by_newton_ = row_.stationarity <= tolerance.stationarity &&
               row_.complementarity <= tolerance.complementarity;
  return by_newton_;
}

}  // namespace conddp
