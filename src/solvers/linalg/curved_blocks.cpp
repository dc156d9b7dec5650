#include "solvers/linalg/curved_blocks.hpp"

#include <algorithm>
#include <cstring>

#include "spatial/lane.hpp"

namespace conddp {
namespace {

constexpr int kLargest = 6;
constexpr int kLanes = (kLargest + kLaneWidth - 1) / kLaneWidth;

template <int n>
void rows_of_size(const CurvedBlock& B, double* X, int stride, int cols) {
  alignas(Lane) double padded[n][kLanes * kLaneWidth] = {};
  for (int i = 0; i < n; ++i) std::copy_n(B.data + i * B.stride, n, padded[i]);
  for (int j = 0; j < cols; ++j, X += stride) {
    Lane sum[kLanes];
    for (int l = 0; l < kLanes; ++l) sum[l] = Lane(0.0);
    for (int i = 0; i < n; ++i)
      for (int l = 0; l < kLanes; ++l) {
        Lane row;
        std::memcpy(&row.v, padded[i] + l * kLaneWidth, sizeof(row.v));
        sum[l] += row * Lane(X[i]);
      }
    std::memcpy(X, sum, n * sizeof(double));
  }
}

template <int n, class S>
void columns_chunk(const CurvedBlock& B, double* X, int stride) {
  S old[n];
  for (int k = 0; k < n; ++k) std::memcpy(&old[k], X + k * stride, sizeof(S));
  for (int j = 0; j < n; ++j) {
    S sum = old[0] * S(B.data[j]);
    for (int k = 1; k < n; ++k) sum += old[k] * S(B.data[k * B.stride + j]);
    std::memcpy(X + j * stride, &sum, sizeof(S));
  }
}

template <int n>
void columns_of_size(const CurvedBlock& B, double* X, int stride, int rows) {
  int i = 0;
  for (; i + kLaneWidth <= rows; i += kLaneWidth) columns_chunk<n, Lane>(B, X + i, stride);
  for (; i < rows; ++i) columns_chunk<n, double>(B, X + i, stride);
}

}  // namespace

void transform_rows(CurvedBlock B, double* X, int stride, int cols) {
  B.n == 6 ? rows_of_size<6>(B, X, stride, cols) : rows_of_size<3>(B, X, stride, cols);
}

void transform_columns(CurvedBlock B, double* X, int stride, int rows) {
  B.n == 6 ? columns_of_size<6>(B, X, stride, rows) : columns_of_size<3>(B, X, stride, rows);
}

}  // namespace conddp
