#pragma once

#include <Eigen/Core>

#include "solvers/linalg/lane_matrix.hpp"

namespace conddp {

/// Quadratic model of the cost to go from a node: V(δx) = Vxᵀ δx + ½ δxᵀ Vxx δx + constant.
struct ValueFunction {
  ValueFunction() = default;
  explicit ValueFunction(int ndx)
      : Vx(Eigen::VectorXd::Zero(ndx)), Vxx(Eigen::MatrixXd::Zero(ndx, ndx)) {}

  Eigen::VectorXd Vx;   ///< ndx
  Eigen::MatrixXd Vxx;  ///< ndx x ndx, symmetric, both triangles stored
};

/// Quadratic model of a knot's cost plus the cost to go, in z = (δx, δu). The memory fits the
/// largest knot of a problem and is shaped for one knot at a time. The Hessian is stored in its
/// lower triangle and in the columns of the controls.
class ActionValue {
 public:
  ActionValue(int ndx, int max_nu)
      : ndx_(ndx), nu_(max_nu), gradient_(ndx + max_nu, 1), hessian_(ndx + max_nu, ndx + max_nu) {}

  /// Shapes the model for a knot with nu controls; the content becomes undefined. Does not
  /// allocate.
  void resize(int nu) {
    nu_ = nu;
    hessian_.resize(nz(), nz());
  }
  int ndx() const { return ndx_; }
  int nu() const { return nu_; }
  int nz() const { return ndx_ + nu_; }

  Eigen::Map<Eigen::VectorXd> Qz() { return {gradient_.data(), nz()}; }
  Eigen::Map<const Eigen::VectorXd> Qz() const { return {gradient_.data(), nz()}; }
  StridedView Qzz() { return hessian_.view(); }
  ConstStridedView Qzz() const { return hessian_.view(); }
  LaneMatrix& Qzz_lanes() { return hessian_; }
  LaneBlock Qz_lanes() { return gradient_.block(nz(), 0, 1); }
  auto Qx() const { return Qz().head(ndx_); }
  auto Qu() const { return Qz().tail(nu_); }
  auto Qxu() const { return Qzz().topRightCorner(ndx_, nu_); }
  /// Adds a multiple of the identity to Qzz.
  void add_to_diagonal(double weight) {
    for (int i = 0; i < nz(); ++i) hessian_.col(i)[i] += weight;
  }
  auto Quu() const { return Qzz().bottomRightCorner(nu_, nu_); }

 private:
  int ndx_;
  int nu_ = 0;
  LaneMatrix gradient_, hessian_;
};

}  // namespace conddp
