#include "solvers/linalg/row_elimination.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/common/tuning.hpp"

namespace conddp {

RowElimination::RowElimination(int max_rows, int columns)
    : rows_(Eigen::MatrixXd::Zero(max_rows, columns)),
      operation_(Eigen::MatrixXd::Zero(max_rows, max_rows)) {}

Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> RowElimination::append() {
  rows_.row(count_).setZero();
  operation_.row(count_).setZero();
  operation_(count_, count_) = 1;
  return rows_.row(count_++);
}

void RowElimination::scale() {
  const auto unknowns = [this](int row) { return rows_.row(row).head(rows_.cols() - 1); };
  double largest = 0;
  for (int i = 0; i < count_; ++i) largest = std::max(largest, unknowns(i).norm());
  for (int i = 0; i < count_; ++i) {
    const double norm = unknowns(i).norm();
    if (norm <= tuning::kRounding * largest) {
      unknowns(i).setZero();
      continue;
    }
    rows_.row(i) /= norm;
    operation_.row(i) /= norm;
  }
}

/// The row from `first_row` on with the largest norm in these columns, and this norm.
std::pair<int, double> RowElimination::largest_row(int first_row, int first_column,
                                                   int columns) const {
  int row = first_row;
  double largest = -1;
  for (int i = first_row; i < count_; ++i) {
    const double norm = rows_.row(i).segment(first_column, columns).norm();
    if (norm > largest) row = i, largest = norm;
  }
  return {row, largest};
}

int RowElimination::orthonormalize(int first_row, int first_column, int columns) {
  int rank = 0;
  for (int j = first_row; j < count_ && rank < columns; ++j, ++rank) {
    const auto [pivot, largest] = largest_row(j, first_column, columns);
    if (!(largest > tuning::kExact)) break;
    rows_.row(j).swap(rows_.row(pivot));
    operation_.row(j).swap(operation_.row(pivot));
    const auto combine = [&](int row, int with, double factor) {
      rows_.row(row) -= factor * rows_.row(with);
      operation_.row(row) -= factor * operation_.row(with);
    };
    const auto part = [&](int row) { return rows_.row(row).segment(first_column, columns); };
    for (int i = first_row; i < j; ++i) combine(j, i, part(j).dot(part(i)));
    const double norm = part(j).norm();
    rows_.row(j) /= norm;
    operation_.row(j) /= norm;
    for (int i = j + 1; i < count_; ++i) combine(i, j, part(i).dot(part(j)));
  }
  return rank;
}

void RowElimination::original_multipliers(const Eigen::Ref<const Eigen::VectorXd>& eta,
                                          Eigen::Ref<Eigen::VectorXd> y) const {
  y.noalias() = operation_.topLeftCorner(count_, count_).transpose() * eta;
}

}  // namespace conddp
