#pragma once

#include "solvers/linalg/lane_matrix.hpp"

namespace conddp {

/// to (cols x rows) ← fromᵀ, by columns with these strides.
void transpose(const double* from, int from_stride, int rows, int cols, double* to, int to_stride);
/// The upper triangle of a square matrix ← the lower one, in its columns from `first_col` on (and
/// maybe in some before it).
void mirror_lower(const LaneBlock& A, int first_col = 0);
/// `to`, a square matrix by columns, ← the symmetric matrix of which `A` holds the lower triangle.
/// Returns whether all of that is finite.
bool copy_symmetric(const LaneBlock& A, double* to, int to_stride);

}  // namespace conddp
