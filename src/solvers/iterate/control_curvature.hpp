#pragma once

#include <vector>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Curvature of the costs in the controls, the scale of weights on controls.
class ControlCurvature {
 public:
  explicit ControlCurvature(const ShootingProblem& problem);

  /// Takes the largest diagonal entry of H_uu at every knot, without the part of the augmentation,
  /// if any, and returns the smallest positive one. Infinite if it is positive at no knot. The
  /// linearization has Gauss-Newton Hessians and was computed with this augmentation.
  double least(const Linearization& linearization, const Augmentation* augmentation);

 private:
  void subtract(const NodeConstraint& c, const Linearization& linearization,
                const Augmentation& augmentation);

  const ShootingProblem& problem_;
  std::vector<const NodeConstraint*> on_controls_;  ///< all other constraints add nothing to H_uu
  Eigen::VectorXd costs_;                           ///< diagonal of H_uu at a knot
  Eigen::VectorXd shifted_, multiplier_, curvature_;
  Eigen::MatrixXd product_;
};

}  // namespace conddp
