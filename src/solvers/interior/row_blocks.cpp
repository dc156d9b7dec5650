#include "solvers/interior/row_blocks.hpp"

#include <algorithm>

namespace conddp {

RowBlocks::RowBlocks(const ShootingProblem& problem) {
  int rows = 0, columns = 0;
  for (const NodeConstraint& c : problem.constraints()) {
    if (c.term->has_pairs()) continue;
    int row = c.row;
    for (const RowBlock& block : c.term->blocks) {
      blocks_.push_back(
          {c.node, row, block.rows, row - problem.constraint_offset(c.node), &block.columns});
      row += block.rows;
      rows = std::max(rows, block.rows);
      columns = std::max(columns, static_cast<int>(block.columns.size()));
    }
  }
  rows_.setZero(columns, rows);
  column_.setZero(columns);
  weights_.setZero(rows);
}

void RowBlocks::add_gradients(const Eigen::VectorXd& f, Linearization& to) const {
  for (const Block& block : blocks_) {
    const auto factors = f.segment(block.row, block.rows);
    if (factors.isZero(0)) continue;
    KnotLinearization& knot = to.knots[block.node];
    for (const int column : *block.columns)
      knot.gradient[column] += knot.C.col(column).segment(block.first, block.rows).dot(factors);
  }
}

void RowBlocks::add_squares(const Eigen::VectorXd& f, const Linearization& linearization,
                            std::vector<Eigen::MatrixXd>& to) {
  for (const Block& block : blocks_) {
    const auto factors = f.segment(block.row, block.rows);
    if (factors.isZero(0)) continue;
    const Eigen::MatrixXd& C = linearization.knots[block.node].C;
    Eigen::MatrixXd& H = to[block.node];
    const std::vector<int>& columns = *block.columns;
    const int n = static_cast<int>(columns.size());
    for (int j = 0; j < n; ++j)
      for (int r = 0; r < block.rows; ++r) rows_(j, r) = C(block.first + r, columns[j]);
    for (int j = 0; j < n; ++j) {
      auto weights = weights_.head(block.rows);
      weights = factors.cwiseProduct(rows_.row(j).head(block.rows).transpose());
      column_.segment(j, n - j).noalias() = rows_.block(j, 0, n - j, block.rows) * weights;
      double* column = H.col(columns[j]).data();
      for (int i = j; i < n; ++i) column[columns[i]] += column_[i];
    }
  }
}

void RowBlocks::multiply(const Linearization& linearization, const std::vector<Eigen::VectorXd>& z,
                         Eigen::VectorXd& out) const {
  for (const Block& block : blocks_) {
    const KnotLinearization& knot = linearization.knots[block.node];
    auto rows = out.segment(block.row, block.rows);
    rows.setZero();
    for (const int column : *block.columns)
      rows += z[block.node][column] * knot.C.col(column).segment(block.first, block.rows);
  }
}

}  // namespace conddp
