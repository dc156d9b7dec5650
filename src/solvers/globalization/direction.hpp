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

/// How an iteration finds its policy δu = α k + K δx: a sweep, or with box-constrained stages
/// several, until the linear model confirms the active set that the sweep assumed.
class Direction {
 public:
  struct Recipe {
    bool clamp_controls = false;
    bool box_stage = false;
    bool null_space = false;  ///< equality constraints are kept by the stages
    Segments segments;        ///< of sweeps with box-constrained stages
  };
  Direction(const ShootingProblem& problem, const ControlBounds& bounds, const Recipe& recipe,
            const SolverOptions::BoxQp& options);

  /// Forgets the active set and the gains of the solve before.
  void reset();
  /// Exchanges the memory of sweeps with another problem's, before both begin a solve.
  void exchange_memory(Direction& other);
  /// From here to the next reset() gains are those of the iterate itself: sweeps go from end to
  /// start, and costs are modelled at the iterate alone.
  void stay_at_iterate() {
    sweep_.use_segments(false);
    models_costs_ = false;
  }
  /// Fills feedback() around an iterate and rolls it out through the linear model. Returns the knot
  /// whose stage has no minimum, or −1. With an augmentation the linearisation is that of the
  /// augmented Lagrangian; it is changed on the way and comes back as it was.
  int find(Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
           const Adjoint& adjoint, SweepRegularization regularization,
           const Augmentation* augmentation = nullptr);

  /// After a sweep without regularisation: corrects k by what former steps tell about the Hessian.
  void correct(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps);
  bool corrected() const { return corrected_; }
  /// Back to the sweep's own k; former steps are forgotten.
  void undo_correction(const Linearization& linearization, const Trajectory& trajectory,
                       const Gaps& gaps);
  /// That the full step has been taken.
  void step_taken() { lbfgs_.step_taken(feedback_); }
  /// Forgets former steps.
  void forget_steps();

  /// Sweeps begun since reset(), of the whole horizon or of its beginning.
  int sweeps() const { return sweeps_; }
  const Feedback& feedback() const { return feedback_; }
  /// Moves the gains out; `to` has their shape.
  void take_feedback(Feedback& to) { std::swap(feedback_, to); }
  const ActiveSet& active_set() const { return stages_->active_set(); }
  /// The stages that keep equality constraints, null where the recipe has none.
  NullSpaceStage* null_space() { return null_space_; }
  /// The policy's full step in the linear model, clamped to bounds as the rollout proper is.
  const LinearRollout& step() const { return linear_rollout_; }
  /// Whether constraints or barriers are rows of the horizon's model.
  bool models_rows() const { return constraints_.has_value(); }
  /// Whether the last find() met a search for the constraints' rows that did not settle.
  bool unsettled() const { return unsettled_; }
  /// Whether that step meets no bound on its way: nothing was clamped.
  bool within_bounds() const { return within_bounds_; }
  /// Whether the controls' active set was looked for along the horizon and not found.
  bool set_unknown() const { return horizon_sweeps_ > 0 && !within_bounds_; }
  /// That dynamics and constraints are affine: the model's exact minimum is worth its sweeps, and a
  /// descent to it where active sets alternate.
  void trust_model() { model_true_ = true; }
  bool trusts_model() const { return model_true_; }
  /// dᵀ Hessian d of the step.
  double curvature(const Linearization& linearization) const {
    return linear_rollout_.curvature(linearization);
  }

 private:
  /// What a direction is looked for around.
  struct Model {
    Linearization& linearization;
    const Trajectory& trajectory;
    const Gaps& gaps;
    const Adjoint& adjoint;
    SweepRegularization regularization;
    bool augmented;  ///< rows of constraints are part of it
  };
  /// The active set that a search along the horizon begins with.
  enum class SetStart {
    from_guess,  ///< controls that it has at bounds, where the gradient pushes them
    as_before,   ///< what the last search ended with
    by_stages,   ///< what stages find, knot by knot
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
  int horizon_sweeps_;
  BackwardSweep sweep_;
  std::unique_ptr<StageSolver> stages_;
  NullSpaceStage* null_space_ = nullptr;
  LinearRollout linear_rollout_;
  std::optional<HorizonConstraints> constraints_;
  std::optional<HorizonDescent> descent_;
  Feedback feedback_;
  LbfgsCorrection lbfgs_;
  bool corrected_ = false;
  bool models_costs_ = true;  ///< that begin at a bound, along the step
  int sweeps_ = 0;
  SetStart set_start_ = SetStart::from_guess;
  std::optional<int> last_change_;  ///< knot, of the active set or the rows since the last sweep
  bool held_before_ = false;        ///< the last sweep held the active set
  bool within_bounds_ = false;
  bool model_true_ = false;
  bool unsettled_ = false;
};

}  // namespace conddp
