#pragma once

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/riccati/linear_rollout.hpp"
#include "solvers/stages/gap_transport.hpp"

namespace conddp {

/// The full step of the linear model, and what becomes of it: all knots are evaluated at once, each
/// from the state that the model gives it, where a rollout goes from knot to knot. Its gaps are of
/// second order. A correction moves the states by what the policy makes of these gaps in the same
/// linear model, after which they are of third order (a second-order correction of Maratos' effect;
/// Nocedal, Wright, section 18.3); every further one takes the step's length off once more.
class FullStep {
 public:
  FullStep(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Whether a trajectory is evaluated, or differentiated at once since it will be the next
  /// iterate: the derivatives then overwrite those of the iterate before.
  enum class Trial { evaluate, differentiate };

  /// Moves a trajectory by the step and evaluates it there. `linearization` is that before the
  /// step.
  void take(Evaluator& evaluator, const LinearRollout& step, Trial trial,
            Linearization& linearization, Trajectory& trajectory,
            const Augmentation* augmentation = nullptr);
  /// Closes the gaps to first order and evaluates the trajectory again. `linearization` is that
  /// before the step, or of the trajectory where that has been differentiated.
  void correct(Evaluator& evaluator, const Feedback& feedback, Trial trial,
               Linearization& linearization, Trajectory& trajectory,
               const Augmentation* augmentation = nullptr);

  /// With the augmentation, where there is one.
  double cost() const { return evaluation_.cost.sum() + evaluation_.augmentation.sum(); }
  const Eigen::MatrixXd& gap() const { return evaluation_.gap; }

 private:
  void try_point(Evaluator& evaluator, const LinearRollout& step, Trial trial,
                 Linearization& linearization, Trajectory& trajectory,
                 const Augmentation* augmentation);

  const ControlBounds& bounds_;
  StateManifold manifold_;
  Evaluation evaluation_;
  Gaps gaps_;
  LinearRollout response_;
};

}  // namespace conddp
