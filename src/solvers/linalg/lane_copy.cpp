#include "solvers/linalg/lane_copy.hpp"

namespace conddp {

void transpose(const double* from, int from_stride, int rows, int cols, double* to, int to_stride) {
  Lane x[kLaneWidth];
  for (int col = 0; col < cols; col += kLaneWidth)
    for (int row = 0; row < rows; row += kLaneWidth) {
      const int rows_left = rows - row, cols_left = cols - col;
      const double* source = from + col * from_stride + row;
      double* target = to + row * to_stride + col;
      if (rows_left >= kLaneWidth && cols_left >= kLaneWidth) {
        load_columns(x, source, from_stride);
        transpose_lanes(x);
        store_columns(x, target, to_stride);
      } else {
        load_columns(x, source, from_stride, rows_left, cols_left);
        transpose_lanes(x);
        store_columns(x, target, to_stride, cols_left, rows_left);
      }
    }
}

void mirror_lower(const LaneBlock& A, int first_col) {
  Lane x[kLaneWidth];
  const int first = first_col / kLaneWidth * kLaneWidth;
  for (int col = 0; col < A.cols; col += kLaneWidth) {
    const int cols = A.cols - col;
    double* square = A.data + col * A.stride + col;
    if (col >= first) {
      load_columns(x, square, A.stride, kLaneWidth, cols);
      mirror_square(x);
      store_columns(x, square, A.stride, kLaneWidth, cols);
    }
    for (int row = std::max(first, col + kLaneWidth); row < A.rows; row += kLaneWidth) {
      load_columns(x, A.data + col * A.stride + row, A.stride);
      transpose_lanes(x);
      store_columns(x, A.data + row * A.stride + col, A.stride, kLaneWidth, A.rows - row);
    }
  }
}

bool copy_symmetric(const LaneBlock& A, double* to, int to_stride) {
  Lane x[kLaneWidth];
  Lane finite(0.0);  // a sum of zeros unless a number is not finite
  const auto check = [&] {
    // Summing the columns first keeps the squares independent of each other.
    finite += sum_of_columns(x) * Lane(0.0);
  };
  for (int col = 0; col < A.cols; col += kLaneWidth) {
    const int cols = A.cols - col;
    load_columns(x, A.data + col * A.stride + col, A.stride, cols, cols);
    mirror_square(x);
    check();
    store_columns(x, to + col * to_stride + col, to_stride, cols, cols);
    for (int row = col + kLaneWidth; row < A.rows; row += kLaneWidth) {
      const int rows = A.rows - row;
      if (rows >= kLaneWidth) {
        load_columns(x, A.data + col * A.stride + row, A.stride);
        check();
        store_columns(x, to + col * to_stride + row, to_stride);
        transpose_lanes(x);
        store_columns(x, to + row * to_stride + col, to_stride);
      } else {
        load_columns(x, A.data + col * A.stride + row, A.stride, rows, kLaneWidth);
        check();
        store_columns(x, to + col * to_stride + row, to_stride, rows, kLaneWidth);
        transpose_lanes(x);
        store_columns(x, to + row * to_stride + col, to_stride, kLaneWidth, rows);
      }
    }
  }
  double sum = 0;
  for (int l = 0; l < kLaneWidth; ++l) sum += finite[l];
  return sum == 0;
}

}  // namespace conddp
