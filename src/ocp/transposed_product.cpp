#include "ocp/transposed_product.hpp"

#include <algorithm>

#include "spatial/lane_part.hpp"

namespace conddp {

void multiply_transposed(const Eigen::MatrixXd& A, const double* x, double* out) {
  const int rows = static_cast<int>(A.rows()), cols = static_cast<int>(A.cols());
  for (int col = 0; col < cols; col += kLaneWidth) {
    const int count = std::min(kLaneWidth, cols - col);
    Lane sum[kLaneWidth];
#pragma GCC unroll 8
    for (int c = 0; c < kLaneWidth; ++c) sum[c] = Lane(0.0);
    const double* from = A.data() + col * rows;
    for (int row = 0; row < rows; row += kLaneWidth) {
      const Lane part = load_some(x + row, rows - row);
#pragma GCC unroll 8
      for (int c = 0; c < kLaneWidth; ++c)
        if (c < count) sum[c] += load_some(from + c * rows + row, rows - row) * part;
    }
    transpose_lanes(sum);
#pragma GCC unroll 8
    for (int c = 1; c < kLaneWidth; ++c) sum[0] += sum[c];
    store_some(out + col, sum[0], count);
  }
}

}  // namespace conddp
