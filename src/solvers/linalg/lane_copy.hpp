#pragma once

#include "solvers/linalg/lane_matrix.hpp"

namespace conddp {

/// to (cols x rows) ← fromᵀ, column-major with these strides.
void transpose(const double* from, int from_stride, int rows, int cols, double* to, int to_stride);
/// Mirrors the lower triangle of a square matrix into the upper one, in its columns from
/// `first_col` on (and possibly in some before it).
void mirror_lower(const LaneBlock& A, int first_col = 0);
/// `to` (square, column-major) ← the symmetric matrix with lower triangle `A`. True if all entries
/// are finite.
bool copy_symmetric(const LaneBlock& A, double* to, int to_stride);

}  // namespace conddp
