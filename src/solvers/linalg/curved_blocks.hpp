#pragma once

namespace conddp {

/// A small block that acts on the n ≤ 6 coordinates of a curved part of the state: entry (i, j) is
/// data[i · stride + j].
struct CurvedBlock {
  const double* data;
  int n, stride;
};

/// n rows of a matrix by columns (`X` points at the first) ← Bᵀ times them.
void transform_rows(CurvedBlock B, double* X, int stride, int cols);
/// n columns of a matrix by columns (`X` points at the first) ← them times B.
void transform_columns(CurvedBlock B, double* X, int stride, int rows);

}  // namespace conddp
