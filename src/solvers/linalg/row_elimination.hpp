#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Linear equations made independent by rank-revealing row operations.
///
/// The rows (A b) of a system A x + b = 0 are orthonormalised in chosen columns by the modified
/// Gram-Schmidt process with row pivoting, done twice: whole rows are combined, so that what they
/// say stays true. Every combination is recorded. Memory is sized at construction.
class RowElimination {
 public:
  RowElimination() = default;
  RowElimination(int max_rows, int columns);

  /// Empties the system.
  void clear() { count_ = 0; }
  /// Appends a row, zero until it is written; returns it.
  Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> append();
  int count() const { return count_; }
  /// Gives every row the norm 1 in all columns but the last, where it is not zero; it is made zero
  /// there where it is rounding beside the largest one.
  void scale();
  /// Makes rows from `first_row` on orthonormal in `columns` columns from `first_column`, as many
  /// as are independent there, and clears those columns of the rows behind. Returns that rank.
  int orthonormalize(int first_row, int first_column, int columns);

  auto rows() { return rows_.topRows(count_); }
  auto rows() const { return rows_.topRows(count_); }
  /// y = Tᵀ η where T are the row operations so far: multipliers of the rows that were appended
  /// from those of the present ones.
  void original_multipliers(const Eigen::Ref<const Eigen::VectorXd>& eta,
                            Eigen::Ref<Eigen::VectorXd> y) const;

 private:
  std::pair<int, double> largest_row(int first_row, int first_column, int columns) const;

  int count_ = 0;
  Eigen::MatrixXd rows_;       ///< max_rows x columns
  Eigen::MatrixXd operation_;  ///< max_rows x max_rows: T
};

}  // namespace conddp
