#pragma once

#include <Eigen/Core>

#include "spatial/aligned.hpp"
#include "spatial/lane.hpp"

namespace conddp {

/// A column-major matrix with padding between its columns.
using StridedView = Eigen::Map<Eigen::MatrixXd, Eigen::Unaligned, Eigen::OuterStride<>>;
using ConstStridedView = Eigen::Map<const Eigen::MatrixXd, Eigen::Unaligned, Eigen::OuterStride<>>;

/// Columns of a LaneMatrix. Each begins on a lane and may be read and written to the end of its
/// last lane. Kernels take it by reference: a copy does not fit the registers of a call and would
/// wait for the stores of its fields, for longer than a small product takes.
struct LaneBlock {
  double* data;
  int stride;  ///< distance between columns
  int rows, cols;

  StridedView view() const { return {data, rows, cols, Eigen::OuterStride<>(stride)}; }
};

/// A column-major matrix for the products of lane_gemm.hpp. Columns are padded to whole lanes, so
/// that kernels need no special case for column ends. The content of the padding is never used.
class LaneMatrix {
 public:
  /// Creates a zero matrix.
  LaneMatrix(int max_rows, int max_cols)
      : rows_(max_rows),
        cols_(max_cols),
        stride_((max_rows + kLaneWidth - 1) / kLaneWidth * kLaneWidth),
        data_(stride_ * max_cols, 0.0) {}

  /// Shapes the matrix within its size at construction; the content becomes undefined.
  void resize(int rows, int cols) { rows_ = rows, cols_ = cols; }
  int rows() const { return rows_; }
  int cols() const { return cols_; }
  int stride() const { return stride_; }
  double* data() { return data_.data(); }
  const double* data() const { return data_.data(); }
  double* col(int j) { return data_.data() + j * stride_; }

  StridedView view() { return {data_.data(), rows_, cols_, Eigen::OuterStride<>(stride_)}; }
  ConstStridedView view() const {
    return {data_.data(), rows_, cols_, Eigen::OuterStride<>(stride_)};
  }
  /// All columns with their padding as one vector, for sums of matrices of the same shape.
  Eigen::Map<Eigen::VectorXd> flat() { return {data_.data(), stride_ * cols_}; }
  LaneBlock block() { return {data_.data(), stride_, rows_, cols_}; }
  /// The first rows of some columns.
  LaneBlock block(int rows, int first_col, int cols) {
    return {col(first_col), stride_, rows, cols};
  }

 private:
  int rows_, cols_, stride_;
  AlignedVector<double> data_;
};

}  // namespace conddp
