#pragma once

#include "solvers/riccati/adjoint.hpp"

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
class ViolationSlope {
 public:
  ViolationSlope(const ShootingProblem& problem, const ControlBounds& bounds);

  /// ‖d‖, of the values of all constraint rows; d stays as distances().
  double violation(const Eigen::VectorXd& values);
  const Eigen::VectorXd& distances() const { return distances_; }
  /// The share, at a trajectory whose violation was asked for last.
  double share(Evaluator& evaluator, const Trajectory& trajectory, const Gaps& gaps);
  /// The same of another gradient than that of ½‖d‖².
  double share(const Eigen::VectorXd& gradient, const Trajectory& trajectory) const;

 private:
  const ShootingProblem& problem_;
  const ControlBounds& bounds_;
  Eigen::VectorXd distances_;
  Augmentation lagrangian_;
  Linearization linearization_;
  Feedback no_feedback_;
  Adjoint adjoint_;
};

}  // namespace conddp
