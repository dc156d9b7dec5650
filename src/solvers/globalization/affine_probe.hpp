#pragma once

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// Tells by one evaluation whether dynamics and constraint rows are affine: whether, around an
/// iterate, a linearisation foretells the gaps and constraint values of a trajectory that is 1 off
/// in every direction.
class AffineProbe {
 public:
  explicit AffineProbe(const ShootingProblem& problem);

  /// `linearization` is that of the trajectory.
  bool holds(Evaluator& evaluator, const Trajectory& trajectory,
             const Linearization& linearization);

 private:
  const ShootingProblem& problem_;
  Trajectory moved_;
  Evaluation evaluation_;
  Eigen::VectorXd z_, next_;    ///< scratch: the move of a knot, and what it makes of the next
  Eigen::VectorXd constraint_;  ///< foretold
};

}  // namespace conddp
