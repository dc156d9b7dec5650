#include "solvers/globalization/direction.hpp"

#include <algorithm>
#include <limits>

#include "solvers/linalg/exchange.hpp"
#include "solvers/stages/stage_solver.hpp"

namespace conddp {
namespace {

/// Allowed number of revisions of an active set without fewer changes than ever before. Sets can
/// alternate, and then stages that find their own sets make better use of further sweeps.
constexpr int kPatience = 4;
/// Allowed growth of the error of the constraints' model, relative to its smallest value.
constexpr double kErrorGrowth = 100;
/// Allowed error of the constraints' model at a step, in the norm of the Hessian H: the squared
/// distance of the step from the model's minimum, as a share of dᵀHd.
constexpr double kModelError = 1e-6;
/// Sweeps per iteration that search the active set of the whole horizon. Between 8 and 30, the
/// iterations of the examples hardly depend on it (docs/measurements/ablations.md).
constexpr int kHorizonSweeps = 20;

}  // namespace

Direction::Direction(const ShootingProblem& problem, const ControlBounds& bounds,
                     const Recipe& recipe)
    : problem_(problem),
      bounds_(bounds),
      recipe_(recipe),
      sweep_(problem, bounds),
      stages_(recipe.box_stage ? box_stage(problem) : unconstrained_stage(problem)),
      linear_rollout_(problem, bounds),
      feedback_(problem),
      lbfgs_(bounds) {
  if (recipe.null_space) {
    auto stages = std::make_unique<NullSpaceStage>(problem);
    null_space_ = stages.get();
    stages_ = std::move(stages);
  }
  if (!recipe.box_stage) return;
  constraints_.emplace(problem);
  if (constraints_->empty())
    constraints_.reset();
  else
    descent_.emplace(problem, bounds);
}

int Direction::find(Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
                    const Adjoint& adjoint, double regularization,
                    const Augmentation* augmentation) {
  const bool augmented = has_rows(augmentation);
  unsettled_ = false;
  if (augmented) {
    constraints_->start(linearization, augmentation);
    constraints_->expect(linearization);
  }
  const Model model{linearization, trajectory, gaps, adjoint, regularization, augmented};
  const int bad_knot = search(model);
  if (augmented && constraints_->restore(linearization)) {
    if (within_bounds_)
      linear_rollout_.measure_slope(linearization);  // slope of the step that settled the search
    else
      roll(model, recipe_.clamp_controls);
  }
  return bad_knot;
}

/// True if the model includes rows, of constraints or of costs that begin at a bound.
bool Direction::has_rows(const Augmentation* augmentation) const {
  return constraints_ &&
         (augmentation != nullptr || (models_costs_ && problem_.constraints().empty()));
}

int Direction::search(const Model& model) {
  last_change_.reset();
  held_before_ = false;
  within_bounds_ = !recipe_.box_stage && !recipe_.clamp_controls;
  return recipe_.box_stage ? search_along_horizon(model) : search_by_stages(model);
}

/// Sweeps until the linear rollout confirms the active set that the sweep assumed, starting from
/// the final set of the previous iteration. If sets alternate instead of settling, a descent
/// minimizes a true model. Otherwise stages find their own sets, around the rows of the iterate.
int Direction::search_along_horizon(const Model& model) {
  const int bad_knot = sweep_first(model);
  if (bad_knot >= 0) return bad_knot;
  if (settle(model)) return -1;
  unsettled_ = model.augmented;
  if (minimize_true_model(model)) return -1;
  set_start_ = SetStart::by_stages;
  if (model.augmented) constraints_->restore(model.linearization);
  return search_by_stages(model);
}

/// Sweeps with the initial active set of the search, or else with the sets that stages find. Far
/// from an optimum, stages hold many controls, each for a step that the next state will not take.
int Direction::sweep_first(const Model& model) {
  if (set_start_ == SetStart::from_guess)
    stages_->active_set().assume_pushed_out(bounds_, model.adjoint.gradient(), model.trajectory);
  const bool swept = set_start_ != SetStart::by_stages && sweep(model, true) < 0;
  const int bad_knot = swept ? -1 : sweep(model, false);
  if (bad_knot < 0) set_start_ = SetStart::as_before;
  return bad_knot;
}

/// Minimizes a true model by a descent, after which the active set may settle. False if the model
/// contains no rows, is not known to be true, or a stage lacks a minimum.
bool Direction::minimize_true_model(const Model& model) {
  if (!model.augmented || !model_true_ || !descend(model)) return false;
  last_change_.reset();
  if (sweep(model, true) >= 0 || !settle(model)) descent_->write(feedback_);
  return true;
}

int Direction::search_by_stages(const Model& model) {
  const int bad_knot = sweep(model, false);
  if (bad_knot < 0) roll(model, recipe_.clamp_controls);
  return bad_knot;
}

/// Consecutive held sweeps cover only the knots up to the last change.
int Direction::sweep(const Model& model, bool hold) {
  const std::optional<int> from = hold && held_before_ ? last_change_ : std::nullopt;
  held_before_ = hold;
  ++sweeps_;
  return sweep_.run(model.linearization, model.trajectory, model.gaps, model.regularization,
                    *stages_, feedback_, hold, from);
}

/// Alternately revises the active set and sweeps until nothing changes. False if this does not end.
bool Direction::settle(const Model& model) {
  int fewest = std::numeric_limits<int>::max(), since = 0;
  double least_error = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kHorizonSweeps; ++i) {
    const int changes = revise(model);
    within_bounds_ = changes == 0;
    if (within_bounds_) {
      if (model.augmented) constraints_->settle();
      return true;
    }
    since = changes < fewest ? 0 : since + 1;
    fewest = std::min(fewest, changes);
    if (since > kPatience) return false;
    if (model.augmented) {
      const double error = constraints_->model_error();
      if (!model_true_ && error > kErrorGrowth * least_error) return false;
      least_error = std::min(least_error, error);
    }
    if (sweep(model, true) >= 0) return false;
  }
  return false;
}

/// Number of the last sweep's assumptions that fail along the horizon.
int Direction::revise(const Model& model) {
  roll(model, false);
  std::optional<int> last_row;
  int rows = 0;
  if (model.augmented) {
    // The model of an affine problem has the same minimum as the problem; other models only give a
    // step.
    const double allowed =
        model_true_ ? 0 : kModelError * linear_rollout_.curvature(model.linearization);
    rows = constraints_->revise(linear_rollout_.z(), allowed, model.linearization, last_row);
  }
  last_change_.reset();
  const int changes = linear_rollout_.revise(stages_->active_set(), last_change_);
  last_change_ = std::max(last_change_, last_row);
  if (last_row == problem_.knots()) last_change_.reset();  // every sweep begins there
  return changes + rows;
}

/// Descends from the iterate along the augmented Lagrangian of the horizon, with bounds as
/// penalties. False if a stage lacks a minimum.
bool Direction::descend(const Model& model) {
  Linearization& linearization = model.linearization;
  constraints_->restore(linearization);
  constraints_->restart();
  linear_rollout_.respond(linearization, model.gaps, feedback_);
  descent_->start(linear_rollout_, model.trajectory, model.adjoint.gradient(), sweep_,
                  *constraints_, linearization);
  stages_->active_set().release();
  bool swept = true;
  for (int i = 0; i < kHorizonSweeps; ++i) {
    ++sweeps_;
    swept = sweep_.run(linearization, model.trajectory, model.gaps, model.regularization, *stages_,
                       feedback_, true) < 0;
    if (!swept) break;
    roll(model, false);
    if (descent_->advance(linear_rollout_, *constraints_, linearization)) break;
  }
  descent_->leave(stages_->active_set(), linearization);
  return swept;
}

void Direction::roll(const Model& model, bool clamp) {
  linear_rollout_.run(model.linearization, model.trajectory, model.gaps, feedback_, clamp);
}

void Direction::correct(const Linearization& linearization, const Trajectory& trajectory,
                        const Gaps& gaps) {
  if (!within_bounds_) {
    forget_steps();
    return;
  }
  lbfgs_.observe(feedback_, sweep_, stages_->active_set());
  corrected_ = lbfgs_.correct(feedback_);
  if (!corrected_) return;
  linear_rollout_.run(linearization, trajectory, gaps, feedback_, false);
  if (step_violates_bounds(trajectory)) undo_correction(linearization, trajectory, gaps);
}

/// True for a violation at a control that the active set leaves free.
bool Direction::step_violates_bounds(const Trajectory& trajectory) const {
  for (int k = 0; k < problem_.knots(); ++k) {
    const auto u = trajectory.u(k);
    const auto du = linear_rollout_.du(k);
    for (int i = 0; i < du.size(); ++i) {
      if (stages_->active_set().holds(k, i)) continue;
      if (u[i] + du[i] < bounds_.lower(k)[i] || u[i] + du[i] > bounds_.upper(k)[i]) return true;
    }
  }
  return false;
}

void Direction::undo_correction(const Linearization& linearization, const Trajectory& trajectory,
                                const Gaps& gaps) {
  lbfgs_.restore(feedback_);
  forget_steps();
  linear_rollout_.run(linearization, trajectory, gaps, feedback_, false);
}

void Direction::forget_steps() {
  lbfgs_.clear();
  corrected_ = false;
}

void Direction::exchange_memory(Direction& other) {
  sweep_.exchange_memory(other.sweep_);
  exchange(feedback_.K, other.feedback_.K);
  if (constraints_ && other.constraints_) constraints_->exchange_memory(*other.constraints_);
}

void Direction::reset() {
  forget_steps();
  models_costs_ = true;
  sweeps_ = 0;
  if (constraints_) constraints_->reset();
  set_start_ = SetStart::from_guess;
  model_true_ = false;
  feedback_.set_zero();
}

}  // namespace conddp
