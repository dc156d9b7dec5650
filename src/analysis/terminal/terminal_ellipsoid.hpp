#pragma once

#include <Eigen/Core>

namespace conddp {

/// Removes rounding from a symmetric matrix that is positive semidefinite up to rounding. Rows and
/// directions that are zero, after scaling the diagonal to ones, become exactly zero. A positive
/// definite matrix is returned unchanged.
Eigen::MatrixXd without_rounding(const Eigen::MatrixXd& matrix);

/// The ellipsoid yᵀP y ≤ 1 of a positive semidefinite P; unbounded along the null space of P.
struct TerminalEllipsoid {
  Eigen::MatrixXd axes;  ///< y = axes·s has yᵀP y = ‖s‖²; the number of columns is the rank of P
  Eigen::MatrixXd free;  ///< orthonormal basis of the null space of P
};

TerminalEllipsoid terminal_ellipsoid(const Eigen::MatrixXd& P);

}  // namespace conddp
