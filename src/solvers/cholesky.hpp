#pragma once

#include <Eigen/Core>

#include "solvers/lane_matrix.hpp"

namespace conddp {

/// Cholesky factors of the small symmetric matrices of a stage, in place and without allocation.

/// A = L Lᵀ from the lower triangle of A, which L overwrites. False where a pivot is not positive
/// beyond rounding (or not finite): then A is left half done.
bool cholesky_in_place(Eigen::Ref<Eigen::MatrixXd> A);

/// B ← B (L Lᵀ)⁻¹: every row of B is a right-hand side, so that lanes run down its columns.
void solve_rows_in_place(const Eigen::Ref<const Eigen::MatrixXd>& L, LaneBlock B);

}  // namespace conddp
