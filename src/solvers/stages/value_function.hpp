#pragma once

#include <Eigen/Core>

namespace conddp {

/// Quadratic model of the cost to go from a node: V(δx) = Vxᵀ δx + ½ δxᵀ Vxx δx + constant.
struct ValueFunction {
  ValueFunction() = default;
  explicit ValueFunction(int ndx)
      : Vx(Eigen::VectorXd::Zero(ndx)), Vxx(Eigen::MatrixXd::Zero(ndx, ndx)) {}

  Eigen::VectorXd Vx;   ///< ndx
  Eigen::MatrixXd Vxx;  ///< ndx x ndx, symmetric, both triangles stored
};

}  // namespace conddp
