#include "solvers/direction.hpp"

#include <utility>

namespace conddp {

Direction::Direction(const ShootingProblem& problem, const ControlBounds& bounds,
                     const Recipe& recipe, const SolverOptions::BoxQp& options)
    : problem_(problem),
      bounds_(bounds),
      recipe_(recipe),
      horizon_sweeps_(recipe.box_stage ? options.horizon_sweeps : 0),
      sweep_(problem, bounds),
      policy_(recipe.box_stage ? box_stage(problem, options) : unconstrained_stage(problem)),
      linear_rollout_(problem, bounds),
      feedback_(problem),
      secants_(bounds) {
  if (horizon_sweeps_ == 0) return;
  remembered_.emplace(
      Remembered{Feedback(problem),
                 std::vector<ValueFunction>(problem.knots() + 1, ValueFunction(problem.ndx())),
                 {}});
  for (int k = 0; k < problem.knots(); ++k) remembered_->Quu.push_back(sweep_.Quu(k));
}

/// Sweeps until the linear rollout confirms the active set that the sweep assumed, from the set
/// that the iteration before ended with. Where sets alternate instead of settling, the set of the
/// iterate itself may grow until the step is feasible; the model says whether that step is better
/// than that of stages which each find their own set.
int Direction::find(const Linearization& linearization, const Trajectory& trajectory,
                    const Gaps& gaps, const Adjoint& adjoint, const MeritModel& merit,
                    SweepRegularization regularization) {
  const auto sweep = [&](bool hold) {
    return sweep_.run(linearization, trajectory, gaps, regularization, *policy_, feedback_, hold);
  };
  const auto roll = [&](bool clamp) {
    linear_rollout_.run(linearization, trajectory, gaps, feedback_, clamp);
  };
  // Whether the set that the last sweep assumed holds all along the horizon.
  const auto confirmed = [&](bool release) {
    roll(false);
    return linear_rollout_.revise(release, *policy_) == 0;
  };
  const auto model_decrease = [&] {
    roll(recipe_.clamp_controls);
    return -(linear_rollout_.slope() + 0.5 * linear_rollout_.curvature(linearization));
  };
  const int limit = horizon_sweeps_;
  within_bounds_ = limit == 0 && !recipe_.clamp_controls;
  if (limit == 0 || !active_set_known_ || sweep(true) >= 0) {
    const int bad_knot = sweep(false);
    if (bad_knot >= 0) return bad_knot;
    if (limit == 0) {
      roll(recipe_.clamp_controls);
      return -1;
    }
  }
  active_set_known_ = true;
  for (int i = 0; i < limit; ++i) {
    within_bounds_ = confirmed(true);
    if (within_bounds_) return -1;
    if (sweep(true) >= 0) break;
  }
  for (int k = 0; k < problem_.knots(); ++k) {
    policy_->assume(k, adjoint.gradient().segment(bounds_.offset(k), problem_.nu(k)));
  }
  bool feasible = false;
  for (int i = 0; i < limit && !feasible && sweep(true) < 0; ++i) feasible = confirmed(false);
  const double held = feasible ? model_decrease() : 0;
  remember();
  const int bad_knot = sweep(false);
  const double own = bad_knot < 0 ? model_decrease() : 0;
  active_set_known_ = feasible && !merit.hidden(held) && (bad_knot >= 0 || own < held);
  if (!active_set_known_) return bad_knot;
  recall();
  within_bounds_ = true;
  roll(false);
  return -1;
}

void Direction::correct(const Linearization& linearization, const Trajectory& trajectory,
                        const Gaps& gaps) {
  if (!within_bounds_) {
    forget_steps();
    return;
  }
  secants_.observe(feedback_, sweep_, *policy_);
  corrected_ = secants_.correct(feedback_);
  if (!corrected_) return;
  linear_rollout_.run(linearization, trajectory, gaps, feedback_, false);
  for (int k = 0; k < problem_.knots(); ++k) {
    const auto u = trajectory.u(k);
    const auto du = linear_rollout_.du(k);
    for (int i = 0; i < du.size(); ++i) {
      if (policy_->holds(k, i)) continue;
      if (u[i] + du[i] < bounds_.lower(k)[i] || u[i] + du[i] > bounds_.upper(k)[i]) {
        undo_correction(linearization, trajectory, gaps);
        return;
      }
    }
  }
}

void Direction::undo_correction(const Linearization& linearization, const Trajectory& trajectory,
                                const Gaps& gaps) {
  secants_.restore(feedback_);
  forget_steps();
  linear_rollout_.run(linearization, trajectory, gaps, feedback_, false);
}

void Direction::forget_steps() {
  secants_.clear();
  corrected_ = false;
}

void Direction::reset() {
  forget_steps();
  active_set_known_ = false;
  for (Eigen::VectorXd& k : feedback_.k) k.setZero();
  for (Eigen::MatrixXd& K : feedback_.K) K.setZero();
}

void Direction::remember() {
  policy_->remember();
  std::swap(remembered_->feedback, feedback_);
  sweep_.swap_values(remembered_->values, remembered_->Quu);
}

void Direction::recall() {
  policy_->recall();
  std::swap(remembered_->feedback, feedback_);
  sweep_.swap_values(remembered_->values, remembered_->Quu);
}

}  // namespace conddp
