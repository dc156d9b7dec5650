#pragma once

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/riccati/linear_rollout.hpp"
#include "solvers/stages/gap_transport.hpp"

namespace conddp {

/// The full step of the linear model and its evaluation. All knots are evaluated at once, each from
/// its state in the model, whereas a rollout goes from knot to knot. The gaps of the step are of
/// second order. A correction moves the states by the policy's response to these gaps in the same
/// linear model, which leaves gaps of third order. This is a second-order correction for the
/// Maratos effect (Nocedal, Wright, section 18.3). Every further correction reduces the gaps by
/// another factor of the step's length.
class FullStep {
 public:
  FullStep(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Mode of a trial: evaluation, or differentiation at once because the trajectory will be the
  /// next iterate. The derivatives then overwrite those of the previous iterate.
  enum class Trial { evaluate, differentiate };

  /// Moves a trajectory by the step and evaluates it there. `linearization` is the one before the
  /// step.
  void take(Evaluator& evaluator, const LinearRollout& step, Trial trial,
            Linearization& linearization, Trajectory& trajectory,
            const Augmentation* augmentation = nullptr);
  /// Closes the gaps to first order and evaluates the trajectory again. `linearization` is the one
  /// before the step, or that of the trajectory if it has been differentiated.
  void correct(Evaluator& evaluator, const Feedback& feedback, Trial trial,
               Linearization& linearization, Trajectory& trajectory,
               const Augmentation* augmentation = nullptr);

  /// Cost of the trial, including the augmentation if any.
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
