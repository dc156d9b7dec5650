#include "solvers/globalization/direction.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace conddp {
namespace {

/// Revisions of constraint rows that may go by without fewer changes than ever before.
constexpr int kPatience = 4;
/// What the constraints' model may be off at a step, in the norm of the Hessian H: the squared
/// distance of the step from the model's minimum, as a share of dᵀHd.
constexpr double kModelError = 1e-6;

}  // namespace

Direction::Direction(const ShootingProblem& problem, const ControlBounds& bounds,
                     const Recipe& recipe, const SolverOptions::BoxQp& options)
    : problem_(problem),
      bounds_(bounds),
      recipe_(recipe),
      horizon_sweeps_(recipe.box_stage ? options.horizon_sweeps : 0),
      sweep_(problem, bounds, recipe.legs),
      policy_(recipe.box_stage ? box_stage(problem, options, recipe.legs.count)
                               : unconstrained_stage(problem)),
      linear_rollout_(problem, bounds),
      feedback_(problem),
      secants_(bounds) {
  if (recipe.null_space) {
    auto stages = std::make_unique<NullSpaceStage>(problem);
    null_space_ = stages.get();
    policy_ = std::move(stages);
  }
  if (horizon_sweeps_ == 0) return;
  constraints_.emplace(problem);
  if (constraints_->empty())
    constraints_.reset();
  else
    descent_.emplace(problem, bounds);
}

int Direction::find(Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
                    const Adjoint& adjoint, SweepRegularization regularization,
                    const Augmentation* augmentation) {
  const bool augmented = constraints_ && (augmentation != nullptr ||
                                          (models_costs_ && problem_.constraints().empty()));
  unsettled_ = false;
  if (augmented) {
    constraints_->start(linearization, augmentation);
    constraints_->expect(linearization);
  }
  const int bad_knot = search(linearization, trajectory, gaps, adjoint, regularization, augmented);
  if (augmented && constraints_->restore(linearization)) {
    if (within_bounds_)
      linear_rollout_.measure_slope(linearization);  // of the step that settled the search
    else
      linear_rollout_.run(linearization, trajectory, gaps, feedback_, recipe_.clamp_controls);
  }
  return bad_knot;
}

/// Sweeps until the linear rollout confirms the active set that the sweep assumed, from the set
/// that the iteration before ended with. Where sets alternate instead of settling, a true model is
/// minimised by a descent; else stages find their own sets, around the rows of the iterate.
int Direction::search(Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
                      const Adjoint& adjoint, SweepRegularization regularization, bool augmented) {
  // Held sweeps after held ones go through what stands before the last change alone: of the active
  // set or of the model's rows.
  std::optional<int> last_change;
  bool held_before = false;
  const auto sweep = [&](bool hold) {
    const std::optional<int> from = hold && held_before ? last_change : std::nullopt;
    held_before = hold;
    ++sweeps_;
    return sweep_.run(linearization, trajectory, gaps, regularization, *policy_, feedback_, hold,
                      from);
  };
  const auto roll = [&](bool clamp) {
    linear_rollout_.run(linearization, trajectory, gaps, feedback_, clamp);
  };
  // How much of what the last sweep assumed does not hold all along the horizon.
  const auto revise = [&] {
    roll(false);
    std::optional<int> last_row;
    int rows = 0;
    if (augmented) {
      // The minimum of an affine problem's model is that of the problem; others give a step.
      const double allowed =
          model_true_ ? 0 : kModelError * linear_rollout_.curvature(linearization);
      rows = constraints_->revise(linear_rollout_.z(), allowed, linearization, last_row);
    }
    last_change.reset();
    const int changes = linear_rollout_.revise(*policy_, last_change);
    last_change = std::max(last_change, last_row);
    if (last_row == problem_.knots()) last_change.reset();  // there every sweep begins
    return changes + rows;
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
  const auto settle = [&] {
    int fewest = std::numeric_limits<int>::max(), since = 0;
    for (int i = 0; i < limit; ++i) {
      const int changes = revise();
      within_bounds_ = changes == 0;
      if (within_bounds_ && augmented) constraints_->settle();
      if (within_bounds_) return true;
      since = changes < fewest ? 0 : since + 1;
      fewest = std::min(fewest, changes);
      if (augmented && since > kPatience) break;
      if (sweep(true) >= 0) break;
    }
    return false;
  };
  if (settle()) return -1;
  unsettled_ = augmented;
  if (augmented && model_true_ &&
      descend(linearization, trajectory, gaps, adjoint, regularization)) {
    last_change.reset();
    if (sweep(true) < 0 && settle()) return -1;
    descent_->write(feedback_);
    return -1;
  }
  active_set_known_ = false;
  if (augmented) constraints_->restore(linearization);
  const int bad_knot = sweep(false);
  if (bad_knot < 0) roll(recipe_.clamp_controls);
  return bad_knot;
}

/// From the iterate itself down the augmented Lagrangian of the horizon, with bounds as penalties.
/// False where a stage has no minimum.
bool Direction::descend(Linearization& linearization, const Trajectory& trajectory,
                        const Gaps& gaps, const Adjoint& adjoint,
                        SweepRegularization regularization) {
  constraints_->restore(linearization);
  constraints_->restart();
  linear_rollout_.respond(linearization, gaps, feedback_);
  descent_->start(linear_rollout_, trajectory, adjoint.gradient(), sweep_, *constraints_,
                  linearization);
  policy_->release();
  bool swept = true;
  for (int i = 0; i < horizon_sweeps_; ++i) {
    ++sweeps_;
    swept =
        sweep_.run(linearization, trajectory, gaps, regularization, *policy_, feedback_, true) < 0;
    if (!swept) break;
    linear_rollout_.run(linearization, trajectory, gaps, feedback_, false);
    if (descent_->advance(linear_rollout_, *constraints_, linearization)) break;
  }
  descent_->leave(*policy_, linearization);
  return swept;
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
  sweep_.use_segments(true);
  models_costs_ = true;
  sweeps_ = 0;
  if (constraints_) constraints_->reset();
  active_set_known_ = model_true_ = false;
  for (Eigen::VectorXd& k : feedback_.k) k.setZero();
  for (Eigen::MatrixXd& K : feedback_.K) K.setZero();
}

}  // namespace conddp
