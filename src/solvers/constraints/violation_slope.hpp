#pragma once

#include "solvers/riccati/adjoint.hpp"
#include "solvers/riccati/linear_rollout.hpp"

namespace conddp {

/// First-order bound on the possible decrease of the violation of hard constraints, by moves of the
/// controls that the states follow.
///
/// With values g, d = g − Π(g) row by row and constraint by constraint, and the violation ‖d‖, the
/// share is
///   Σ_i |∂‖d‖/∂u_i| s_i / ‖d‖.
/// Here s_i is the distance that control i can move downhill to its bound; without a bound, it is
/// the largest size of a control anywhere, at least 1. Distances from convex sets lie above their
/// tangents. If the share is below 1, no such move satisfies the linearized constraints. This is a
/// proof if dynamics and constraints are affine and controls bounded.
///
/// A control without a bound may move further than it has so far. The steepest descent p of such
/// controls yields a lower limit of the share, independent of units. This limit is the part of ‖d‖²
/// that the best step along p removes,
///   (pᵀp)² / (‖J p‖² ‖d‖²),
/// where J is the Jacobian of the rows outside their sets.
class ViolationSlope {
 public:
  ViolationSlope(const ShootingProblem& problem, const ControlBounds& bounds);

  /// ‖d‖ for the values of all constraint rows; distances() returns d.
  double violation(const Eigen::VectorXd& values);
  const Eigen::VectorXd& distances() const { return distances_; }
  /// The share at the trajectory of the last violation().
  double share(Evaluator& evaluator, const Trajectory& trajectory, const Gaps& gaps);
  /// The sum above for another gradient than that of ½‖d‖².
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
