#include "ocp/problem/control_columns.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace conddp {
namespace {

/// Index of the column with this name, or the number of columns if not found.
int index_of(const std::string& name, const std::vector<Column>& columns) {
  return static_cast<int>(std::ranges::find(columns, name, &Column::name) - columns.begin());
}

}  // namespace

ControlColumns::ControlColumns(const ShootingProblem& problem)
    : problem_(problem), phases_(problem.phases().size()) {
  // Jumps and impulses lack controls; the controls of an initial-state choice are of another kind.
  std::vector<bool> is_in_table(phases_.size(), false);
  for (int k = 0; k < problem.knots(); ++k)
    is_in_table[problem.knot(k).phase] = !problem.takes_no_time(k);
  for (std::size_t p = 0; p < phases_.size(); ++p) {
    if (!is_in_table[p]) continue;
    for (const Column& control : problem.phases()[p].model->system().control_columns()) {
      phases_[p].push_back(index_of(control.name, columns_));
      if (phases_[p].back() == count()) columns_.push_back(control);
    }
  }
  std::vector<int> all(columns_.size());
  std::iota(all.begin(), all.end(), 0);
  for (std::size_t p = 0; p < phases_.size(); ++p)
    if (phases_[p] == all) phases_[p].clear();
}

Eigen::VectorXd ControlColumns::row(int knot, const Eigen::VectorXd& own) const {
  return rows(knot, own);
}

Eigen::MatrixXd ControlColumns::rows(int knot, const Eigen::MatrixXd& own) const {
  if (!are_some(knot)) return own;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd table = Eigen::MatrixXd::Constant(count(), own.cols(), kNone);
  const std::span<const int> columns = columns_of(knot);
  for (std::size_t i = 0; i < columns.size(); ++i) table.row(columns[i]) = own.row(i);
  return table;
}

Eigen::VectorXd ControlColumns::own(int knot, const Eigen::VectorXd& row) const {
  if (!are_some(knot) || row.size() != count()) return row;
  const std::span<const int> columns = columns_of(knot);
  Eigen::VectorXd own(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) own[i] = row[columns[i]];
  return own;
}

}  // namespace conddp
