#pragma once

#include <memory>

#include <Eigen/Core>

#include "ocp/terms/residual.hpp"

namespace conddp {

/// Eigenvalues of a weight matrix, scaled to a unit diagonal, count as nonnegative above this
/// value: matrices are written with few digits.
inline constexpr double kLeastWeightEigenvalue = -1e-9;

/// The smallest eigenvalue of a symmetric matrix scaled to a unit diagonal, which decides whether
/// it is positive semidefinite; −∞ if a diagonal entry is negative, or zero in a nonzero row.
double least_scaled_eigenvalue(const Eigen::MatrixXd& matrix);

/// L with L Lᵀ = matrix; the number of its columns is the rank of the matrix. Throws
/// std::invalid_argument if the matrix is not positive semidefinite.
Eigen::MatrixXd weight_factor(const Eigen::MatrixXd& matrix);

/// Lᵀ r of a residual r and a weight matrix W = L Lᵀ, for quadratic costs and ellipsoids with a
/// full matrix: ½‖Lᵀ r‖² = ½ rᵀ W r. Rows of r remain separate unless W or a block of the Jacobian
/// couples them. Parameters: those of r. Throws std::invalid_argument if W is not symmetric,
/// positive semidefinite and of the size of r, or if r is too large.
std::shared_ptr<const Residual> weighted_residual(std::shared_ptr<const Residual> residual,
                                                  const Eigen::MatrixXd& matrix);

}  // namespace conddp
