#pragma once

#include <Eigen/Core>

namespace conddp {

/// A symmetric matrix that is positive semidefinite but for rounding, without that: rows that are
/// zero, scaled to a diagonal of ones, are exactly zero, and so are directions. One that is
/// positive definite stays as it is.
Eigen::MatrixXd without_rounding(const Eigen::MatrixXd& matrix);

/// The ellipsoid yᵀP y ≤ 1 of a positive semidefinite P, which is unbounded where P is zero.
struct TerminalEllipsoid {
  Eigen::MatrixXd axes;  ///< y = axes·s has yᵀP y = ‖s‖²; as many columns as P has rank
  Eigen::MatrixXd free;  ///< an orthonormal basis of the directions in which P is zero
};

TerminalEllipsoid terminal_ellipsoid(const Eigen::MatrixXd& P);

}  // namespace conddp
