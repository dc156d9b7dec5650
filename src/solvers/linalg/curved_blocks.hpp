#pragma once

namespace conddp {

/// A small block that acts on the n ≤ 6 coordinates of a curved part of the state. Entry (i, j) is
/// data[i · stride + j].
struct CurvedBlock {
  const double* data;
  int n, stride;
};

/// Multiplies n rows of a column-major matrix by Bᵀ from the left; `X` points to the first row.
void transform_rows(CurvedBlock B, double* X, int stride, int cols);
/// Multiplies n columns of a column-major matrix by B from the right; `X` points to the first
/// column.
void transform_columns(CurvedBlock B, double* X, int stride, int rows);

}  // namespace conddp
