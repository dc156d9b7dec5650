#pragma once

#include <memory>
#include <utility>

#include "solvers/constraints/horizon_qp.hpp"
#include "solvers/globalization/lbfgs_correction.hpp"
#include "solvers/riccati/adjoint.hpp"
#include "solvers/riccati/null_space_stage.hpp"

namespace conddp {

/// Finds the policy δu = α k + K δx of an iteration: the minimum of the horizon QP, corrected by
/// what earlier steps reveal about the Hessian.
class Direction {
 public:
  struct Recipe {
    bool clamp_controls = false;
    bool box_stage = false;
    bool null_space = false;  ///< the stages enforce equality constraints
  };
  Direction(const ShootingProblem& problem, const ControlBounds& bounds, const Recipe& recipe);

  /// Forgets the active set and the gains of the previous solve. `sweeps`: limit of the next one.
  void reset(int sweeps);
  /// Exchanges the memory of sweeps with another problem's direction, before both begin a solve.
  void exchange_memory(Direction& other) { qp_.exchange_memory(other.qp_); }
  /// Fills feedback() around an iterate and rolls it out through the linear model. Returns the knot
  /// of a stage without a minimum, or −1. With an augmentation, the linearization is that of the
  /// augmented Lagrangian; it is changed temporarily and then restored.
  int find(Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
           const Adjoint& adjoint, double regularization,
           const Augmentation* augmentation = nullptr) {
    return qp_.minimize({linearization, trajectory, gaps, adjoint.gradient(), regularization},
                        augmentation);
  }

  /// Corrects k by information about the Hessian from earlier steps. To be called after a sweep
  /// without regularization.
  void correct(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps);
  bool corrected() const { return corrected_; }
  /// Restores the sweep's own k and forgets earlier steps.
  void undo_correction(const Linearization& linearization, const Trajectory& trajectory,
                       const Gaps& gaps);
  /// Records that the full step was taken.
  void step_taken() { lbfgs_.step_taken(feedback()); }
  /// Forgets earlier steps.
  void forget_steps();

  HorizonQp& qp() { return qp_; }
  const HorizonQp& qp() const { return qp_; }
  const Feedback& feedback() const { return qp_.feedback(); }
  /// Swaps the gains into `to`, which has their shape.
  void take_feedback(Feedback& to) { std::swap(qp_.feedback(), to); }
  /// The stages that enforce equality constraints; null if the recipe does not use them.
  NullSpaceStage* null_space() { return null_space_; }
  /// The policy's full step in the linear model, clamped to the bounds as in the nonlinear rollout.
  const LinearRollout& step() const { return qp_.step(); }
  /// dᵀ Hessian d of the step.
  double curvature(const Linearization& linearization) const {
    return step().curvature(linearization);
  }

 private:
  std::unique_ptr<StageSolver> make_stages(const ShootingProblem& problem, const Recipe& recipe);
  bool step_violates_bounds(const Trajectory& trajectory) const;

  const ControlBounds& bounds_;
  NullSpaceStage* null_space_ = nullptr;
  HorizonQp qp_;
  LbfgsCorrection lbfgs_;
  bool corrected_ = false;
};

}  // namespace conddp
