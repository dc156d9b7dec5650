#pragma once

#include "solvers/linalg/lane_matrix.hpp"

namespace conddp {

/// Cholesky factorization of a stage's small symmetric matrices, in place and without allocation.

/// A = L Lᵀ from the lower triangle of A, which L overwrites; entries above the diagonal become
/// undefined. False if a pivot is not finite or not positive beyond rounding; A is then partly
/// overwritten.
bool cholesky_in_place(const LaneBlock& A);

/// B ← B (L Lᵀ)⁻¹: every row of B is a right-hand side, so that lanes run down its columns.
void solve_rows_in_place(const LaneBlock& L, const LaneBlock& B);

}  // namespace conddp
