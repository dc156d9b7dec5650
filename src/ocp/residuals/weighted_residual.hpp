#pragma once

#include <memory>

#include <Eigen/Core>

#include "ocp/terms/residual.hpp"

namespace conddp {

/// Eigenvalues of a weight matrix, scaled to a diagonal of ones, that are above minus this count as
/// not negative: matrices are written with few digits.
inline constexpr double kLeastWeightEigenvalue = -1e-9;

/// The least eigenvalue of a symmetric matrix scaled to a diagonal of ones, by which it is positive
/// semidefinite or not; −∞ where a row beside a diagonal that is not positive is not zero.
double least_scaled_eigenvalue(const Eigen::MatrixXd& matrix);

/// L with L Lᵀ = matrix, and as many columns as the matrix has rank. Throws std::invalid_argument
/// where the matrix is not positive semidefinite.
Eigen::MatrixXd weight_factor(const Eigen::MatrixXd& matrix);

/// Lᵀ r of a residual r and a weight matrix W = L Lᵀ, so that ½‖Lᵀ r‖² = ½ rᵀ W r: what quadratic
/// costs and ellipsoids with a full matrix are of. Rows of r that neither W nor a block of its
/// Jacobian ties to others stay apart. Parameters: those of r. Throws std::invalid_argument where W
/// is not symmetric, positive semidefinite and of the size of r, or r is too large.
std::shared_ptr<const Residual> weighted_residual(std::shared_ptr<const Residual> residual,
                                                  const Eigen::MatrixXd& matrix);

}  // namespace conddp
