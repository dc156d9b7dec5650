#pragma once

#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Entries of a knot's Hessian that may be nonzero.
enum class HessianFill {
  lasting,  ///< the first entries of the model's pattern, which its costs always fill
  pattern,  ///< all entries of the pattern
  all,
};

/// The symmetric nz x nz Hessian of a knot. It tracks which entries may be nonzero, so all writes
/// go through `change`.
class KnotHessian {
 public:
  KnotHessian() = default;
  /// Zero matrix; `lasting` lists the entries (row, column), row >= column, that costs always fill.
  KnotHessian(int nz, std::span<const std::pair<int, int>> lasting);

  const Eigen::MatrixXd& operator()() const { return matrix_; }
  /// The matrix for writing, only into the entries of `fill`. All others are zero, or keep their
  /// values if `fill` is `all`.
  Eigen::MatrixXd& change(HessianFill fill = HessianFill::all) {
    if (fill_ > fill) matrix_.setZero();
    fill_ = fill;
    return matrix_;
  }

  HessianFill fill() const { return fill_; }
  /// Start of kLaneWidth entries of a column in the lower triangle, at least one of them lasting.
  struct LanePlace {
    int row;  ///< a multiple of kLaneWidth
    int column;
  };
  const std::vector<LanePlace>& lasting_lanes() const { return lasting_lanes_; }

 private:
  Eigen::MatrixXd matrix_;
  HessianFill fill_ = HessianFill::all;
  std::vector<LanePlace> lasting_lanes_;
};

}  // namespace conddp
