#pragma once

#include "solvers/linalg/lane_matrix.hpp"

namespace conddp {

/// Cholesky factors of the small symmetric matrices of a stage, in place and without allocation.

/// A = L Lᵀ from the lower triangle of A, which L overwrites; what stands above it becomes
/// undefined. False where a pivot is not positive beyond rounding (or not finite): then A is left
/// half done.
bool cholesky_in_place(const LaneBlock& A);

/// B ← B (L Lᵀ)⁻¹: every row of B is a right-hand side, so that lanes run down its columns.
void solve_rows_in_place(const LaneBlock& L, const LaneBlock& B);

}  // namespace conddp
