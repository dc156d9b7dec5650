#pragma once

#include <vector>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/augmentation.hpp"

namespace conddp {

/// The curvature that costs have in the controls, by which weights on controls are large or small.
class ControlCurvature {
 public:
  explicit ControlCurvature(const ShootingProblem& problem);

  /// The largest diagonal entry of a knot's H_uu without what the augmentation, if any, adds, and
  /// of that the least over all knots where it is positive; infinite where it is so nowhere. The
  /// linearisation has Gauss-Newton Hessians and was made with this augmentation.
  double least(const Linearization& linearization, const Augmentation* augmentation);

 private:
  void subtract(const NodeConstraint& c, const Linearization& linearization,
                const Augmentation& augmentation);

  const ShootingProblem& problem_;
  std::vector<const NodeConstraint*> on_controls_;  ///< the others add nothing there
  Eigen::VectorXd costs_;                           ///< of the controls of a knot
  Eigen::VectorXd shifted_, multiplier_, curvature_;
  Eigen::MatrixXd product_;
};

}  // namespace conddp
