#pragma once

#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Which entries of a knot's Hessian can be other than zero.
enum class HessianFill {
  lasting,  ///< the first of the model's pattern, those that its costs always fill
  pattern,  ///< those of the pattern
  all,
};

/// The symmetric nz x nz Hessian of a knot, which knows what can be other than zero in it. Nothing
/// writes into it but through `change`, so that what it knows stays true.
class KnotHessian {
 public:
  KnotHessian() = default;
  /// Zero, with the places (row, column), row >= column, that costs always fill.
  KnotHessian(int nz, std::span<const std::pair<int, int>> lasting);

  const Eigen::MatrixXd& operator()() const { return matrix_; }
  /// To be written in the entries of `fill` alone; all others are zero, or keep what they had where
  /// `fill` is `all`.
  Eigen::MatrixXd& change(HessianFill fill = HessianFill::all) {
    if (fill_ > fill) matrix_.setZero();
    fill_ = fill;
    return matrix_;
  }

  HessianFill fill() const { return fill_; }
  /// Where kLaneWidth entries of a column of the lower triangle begin of which some are lasting.
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
