#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "solvers/constraints/horizon_rows.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/riccati/linear_rollout.hpp"

namespace conddp {

/// The quadratic program of the horizon,
///   min ½ zᵀ H z + gᵀ z over the linearized dynamics,
/// with bounds on the controls and with rows: constraints, costs that begin at a bound, cones, and
/// limited multipliers (HorizonRows).
///
/// A Riccati sweep with an assumed active set gives a policy, the linear model a step. The step
/// revises the set: held controls, which stages put at their bounds exactly, and models of the
/// rows. Sweeps repeat until nothing changes. The set of one search starts the next one.
class HorizonQp {
 public:
  /// A linearized iterate.
  struct Model {
    Linearization& linearization;
    const Trajectory& trajectory;
    const Gaps& gaps;
    const Eigen::VectorXd& gradient;  ///< ∇_u L of all knots, stacked
    double regularization = 0;
  };
  /// With `bounded`, the stages have an active set (box_stage). With `clamp`, steps without a
  /// settled set are clamped to the bounds of the controls.
  HorizonQp(const ShootingProblem& problem, const ControlBounds& bounds,
            std::unique_ptr<StageSolver> stages, bool bounded, bool clamp);

  /// Forgets the active set and the gains of the previous solve. The next one may begin `most`
  /// sweeps before may_sweep() ends its searches.
  void reset(int most = std::numeric_limits<int>::max());
  /// Exchanges the memory of sweeps with another problem's QP, before both begin a solve.
  void exchange_memory(HorizonQp& other);
  /// Models costs only at the iterate until the next reset().
  void stay_at_iterate() { models_costs_ = false; }
  /// Declares that dynamics and constraints are affine. The exact minimum of the model is then
  /// worth its sweeps, and worth a descent if active sets alternate.
  void trust_model() { model_true_ = true; }
  bool trusts_model() const { return model_true_; }

  /// Minimizes around an iterate. With an augmentation, the linearization is that of the augmented
  /// Lagrangian; it is changed temporarily and then restored. If active sets alternate instead of
  /// settling, a descent minimizes a true model; otherwise stages find their own sets, around the
  /// rows of the iterate. Returns the knot of a stage without a minimum, or −1.
  int minimize(const Model& model, const Augmentation* augmentation);
  /// Minimizes over the constraints, by the proximal method of multipliers with this ρ, starting
  /// from the rows of `rows().choose` and their multipliers. The linearization has the costs alone,
  /// and the rows are added to it. `multipliers` ← those of the minimum. False if a stage lacks a
  /// minimum.
  bool satisfy(const Model& model, double penalty, Eigen::VectorXd& multipliers);

  HorizonRows& rows() { return rows_; }
  const HorizonRows& rows() const { return rows_; }
  const ActiveSet& active_set() const { return stages_->active_set(); }
  const BackwardSweep& last_sweep() const { return sweep_; }
  Feedback& feedback() { return feedback_; }
  const Feedback& feedback() const { return feedback_; }
  /// The policy's full step in the linear model.
  const LinearRollout& step() const { return rollout_; }
  /// Rolls the policy out again, after a change.
  void roll(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps) {
    rollout_.run(linearization, trajectory, gaps, feedback_, false);
  }
  /// Number of sweeps begun since reset(), over the whole horizon or its beginning.
  int sweeps() const { return sweeps_; }
  bool may_sweep() const { return sweeps_ < most_sweeps_; }
  /// True if constraints or barriers are rows of the model.
  bool has_rows() const { return bounded_ && !rows_.empty(); }
  /// True if the last minimize() searched the active constraint rows without settling.
  bool unsettled() const { return unsettled_; }
  /// True if the step meets no bound: nothing was clamped.
  bool within_bounds() const { return within_bounds_; }
  /// True if the search for the controls' active set along the horizon failed.
  bool set_unknown() const { return bounded_ && !within_bounds_; }

 private:
  /// Active set at the start of a search along the horizon.
  enum class SetStart {
    from_guess,  ///< the guess's controls at bounds that a descent would cross
    as_before,   ///< the final set of the last search
    by_stages,   ///< the sets that stages find, knot by knot
  };
  int search_along_horizon(const Model& model);
  int sweep_first(const Model& model);
  bool minimize_true_model(const Model& model);
  int search_by_stages(const Model& model);
  int sweep(const Model& model, bool hold);
  bool settle(const Model& model);
  int revise(const Model& model);
  bool descend(const Model& model);
  bool advance(const Model& model);
  double step_length(const Model& model);
  void write_point();
  void roll(const Model& model, bool clamp) {
    rollout_.run(model.linearization, model.trajectory, model.gaps, feedback_, clamp);
  }

  const ShootingProblem& problem_;
  const ControlBounds& bounds_;
  bool bounded_, clamp_;
  BackwardSweep sweep_;
  std::unique_ptr<StageSolver> stages_;
  LinearRollout rollout_;
  HorizonRows rows_;
  Feedback feedback_;
  std::vector<Eigen::VectorXd> point_;  ///< of a descent: (δx, δu) of each node
  Eigen::VectorXd d_, product_;
  bool models_costs_ = true;  ///< models costs that begin at a bound along the step
  bool models_rows_ = false;  ///< the current model includes rows
  int sweeps_ = 0, most_sweeps_ = std::numeric_limits<int>::max();
  SetStart set_start_ = SetStart::from_guess;
  std::optional<int> last_change_;  ///< last changed knot, of the active set or the rows
  bool held_before_ = false;        ///< the last sweep held the active set
  bool within_bounds_ = false;
  bool model_true_ = false;
  bool unsettled_ = false;
};

}  // namespace conddp
