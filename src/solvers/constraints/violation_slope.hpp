#pragma once

#include "solvers/riccati/adjoint.hpp"
#include "solvers/riccati/linear_rollout.hpp"

namespace conddp {

/// How far the violation of hard constraints could fall, to first order, by moves of the controls
/// from which the states follow.
///
/// With values g, d = g − Π(g) row by row and constraint by constraint, and ‖d‖ the violation, the
/// share is
///   Σ_i |∂‖d‖/∂u_i| s_i / ‖d‖,
/// where s_i is how far control i can go, downhill, to its bound; without a bound the largest size
/// that it has anywhere, at least 1. Distances from convex sets lie above their tangents: below 1
/// the linearised constraints cannot be satisfied by any such move, and where dynamics and
/// constraints are affine and controls bounded that is a proof.
///
/// A control without a bound may go further than it has gone so far. So the share is at least that
/// of ‖d‖² which the best step along the steepest descent p of such controls takes, whatever their
/// unit: (pᵀp)² / (‖J p‖² ‖d‖²) with J the Jacobian of the rows outside of their sets.
class ViolationSlope {
 public:
  ViolationSlope(const ShootingProblem& problem, const ControlBounds& bounds);

  /// ‖d‖, of the values of all constraint rows; d stays as distances().
  double violation(const Eigen::VectorXd& values);
  const Eigen::VectorXd& distances() const { return distances_; }
  /// The share, at a trajectory whose violation was asked for last.
  double share(Evaluator& evaluator, const Trajectory& trajectory, const Gaps& gaps);
  /// The sum above, of another gradient than that of ½‖d‖².
  double share(const Eigen::VectorXd& gradient, const Trajectory& trajectory) const;

 private:
  double free_share(const Eigen::VectorXd& gradient, const Trajectory& trajectory);
  double squared_change() const;

  const ShootingProblem& problem_;
  const ControlBounds& bounds_;
  Eigen::VectorXd distances_;
  Augmentation lagrangian_;
  Linearization linearization_;
  Feedback no_feedback_, descent_;
  Gaps closed_;
  LinearRollout rollout_;
  Adjoint adjoint_;
};

}  // namespace conddp
