#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "solvers/constraints/horizon_constraints.hpp"
#include "solvers/constraints/horizon_descent.hpp"
#include "solvers/globalization/lbfgs_correction.hpp"
#include "solvers/riccati/adjoint.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/riccati/linear_rollout.hpp"
#include "solvers/riccati/null_space_stage.hpp"

namespace conddp {

/// Finds the policy δu = α k + K δx of an iteration. This takes one sweep or, with box-constrained
/// stages, several, until the linear model confirms the active set that the sweep assumed.
class Direction {
 public:
  struct Recipe {
    bool clamp_controls = false;
    bool box_stage = false;
    bool null_space = false;  ///< the stages enforce equality constraints
  };
  Direction(const ShootingProblem& problem, const ControlBounds& bounds, const Recipe& recipe);

  /// Forgets the active set and the gains of the previous solve.
  void reset();
  /// Exchanges the memory of sweeps with another problem's direction, before both begin a solve.
  void exchange_memory(Direction& other);
  /// Restricts gains to the iterate itself until the next reset(): costs are modeled only there.
  void stay_at_iterate() { models_costs_ = false; }
  /// Fills feedback() around an iterate and rolls it out through the linear model. Returns the knot
  /// of a stage without a minimum, or −1. With an augmentation, the linearization is that of the
  /// augmented Lagrangian; it is changed temporarily and then restored.
  int find(Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
           const Adjoint& adjoint, double regularization,
           const Augmentation* augmentation = nullptr);

  /// Corrects k by information about the Hessian from earlier steps. To be called after a sweep
  /// without regularization.
  void correct(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps);
  bool corrected() const { return corrected_; }
  /// Restores the sweep's own k and forgets earlier steps.
  void undo_correction(const Linearization& linearization, const Trajectory& trajectory,
                       const Gaps& gaps);
  /// Records that the full step was taken.
  void step_taken() { lbfgs_.step_taken(feedback_); }
  /// Forgets earlier steps.
  void forget_steps();

  /// Number of sweeps begun since reset(), over the whole horizon or its beginning.
  int sweeps() const { return sweeps_; }
  const Feedback& feedback() const { return feedback_; }
  /// Swaps the gains into `to`, which has their shape.
  void take_feedback(Feedback& to) { std::swap(feedback_, to); }
  const ActiveSet& active_set() const { return stages_->active_set(); }
  /// The stages that enforce equality constraints; null if the recipe does not use them.
  NullSpaceStage* null_space() { return null_space_; }
  /// The policy's full step in the linear model, clamped to the bounds as in the nonlinear rollout.
  const LinearRollout& step() const { return linear_rollout_; }
  /// True if constraints or barriers are rows of the horizon's model.
  bool models_rows() const { return constraints_.has_value(); }
  /// True if the last find() searched the active constraint rows without settling.
  bool unsettled() const { return unsettled_; }
  /// True if that step meets no bound: nothing was clamped.
  bool within_bounds() const { return within_bounds_; }
  /// True if the search for the controls' active set along the horizon failed.
  bool set_unknown() const { return recipe_.box_stage && !within_bounds_; }
  /// Declares that dynamics and constraints are affine. The exact minimum of the model is then
  /// worth its sweeps, and worth a descent if active sets alternate.
  void trust_model() { model_true_ = true; }
  bool trusts_model() const { return model_true_; }
  /// dᵀ Hessian d of the step.
  double curvature(const Linearization& linearization) const {
    return linear_rollout_.curvature(linearization);
  }

 private:
  /// The model around which a direction is found.
  struct Model {
    Linearization& linearization;
    const Trajectory& trajectory;
    const Gaps& gaps;
    const Adjoint& adjoint;
    double regularization;
    bool augmented;  ///< it includes rows of constraints
  };
  /// Active set at the start of a search along the horizon.
  enum class SetStart {
    from_guess,  ///< the guess's controls at bounds that a descent would cross
    as_before,   ///< the final set of the last search
    by_stages,   ///< the sets that stages find, knot by knot
  };
  bool has_rows(const Augmentation* augmentation) const;
  int search(const Model& model);
  int search_along_horizon(const Model& model);
  int sweep_first(const Model& model);
  bool minimize_true_model(const Model& model);
  int search_by_stages(const Model& model);
  int sweep(const Model& model, bool hold);
  bool settle(const Model& model);
  int revise(const Model& model);
  bool descend(const Model& model);
  void roll(const Model& model, bool clamp);
  bool step_violates_bounds(const Trajectory& trajectory) const;

  const ShootingProblem& problem_;
  const ControlBounds& bounds_;
  Recipe recipe_;
  BackwardSweep sweep_;
  std::unique_ptr<StageSolver> stages_;
  NullSpaceStage* null_space_ = nullptr;
  LinearRollout linear_rollout_;
  std::optional<HorizonConstraints> constraints_;
  std::optional<HorizonDescent> descent_;
  Feedback feedback_;
  LbfgsCorrection lbfgs_;
  bool corrected_ = false;
  bool models_costs_ = true;  ///< models costs that begin at a bound along the step
  int sweeps_ = 0;
  SetStart set_start_ = SetStart::from_guess;
  std::optional<int> last_change_;  ///< last changed knot, of the active set or the rows
  bool held_before_ = false;        ///< the last sweep held the active set
  bool within_bounds_ = false;
  bool model_true_ = false;
  bool unsettled_ = false;
};

}  // namespace conddp
