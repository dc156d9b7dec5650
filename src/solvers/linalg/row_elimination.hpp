#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Linear equations made independent by rank-revealing row operations.
///
/// The rows (A b) of a system A x + b = 0 are orthonormalized in selected columns, by the modified
/// Gram-Schmidt process with row pivoting and reorthogonalization. Whole rows are combined, so that
/// the equations stay valid, and every combination is recorded. Memory is sized at construction.
class RowElimination {
 public:
  RowElimination() = default;
  RowElimination(int max_rows, int columns);

  void clear() { count_ = 0; }
  /// Appends a zero row and returns it for writing.
  Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> append();
  int count() const { return count_; }
  /// Scales every nonzero row to norm 1 in all columns but the last. In these columns, rows that
  /// are rounding compared with the largest one become zero.
  void scale();
  /// Makes rows from `first_row` on orthonormal in `columns` columns from `first_column`, as many
  /// as are independent there, and clears those columns in the remaining rows. Returns the rank.
  int orthonormalize(int first_row, int first_column, int columns);

  auto rows() { return rows_.topRows(count_); }
  auto rows() const { return rows_.topRows(count_); }
  /// y = Tᵀ η, where T contains the row operations so far. This converts multipliers of the present
  /// rows into multipliers of the appended rows.
  void original_multipliers(const Eigen::Ref<const Eigen::VectorXd>& eta,
                            Eigen::Ref<Eigen::VectorXd> y) const;

 private:
  std::pair<int, double> largest_row(int first_row, int first_column, int columns) const;

  int count_ = 0;
  Eigen::MatrixXd rows_;       ///< max_rows x columns
  Eigen::MatrixXd operation_;  ///< max_rows x max_rows: T
};

}  // namespace conddp
