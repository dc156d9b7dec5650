#pragma once

#include <span>
#include <vector>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Positions of each knot's controls in tables of all controls of a problem. The columns are the
/// controls of all phases with a duration, in order of first appearance.
class ControlColumns {
 public:
  explicit ControlColumns(const ShootingProblem& problem);

  int count() const { return static_cast<int>(columns_.size()); }
  const std::vector<Column>& columns() const { return columns_; }
  /// True if a knot uses only some of the columns. Other knots use all of them in order, or lack
  /// controls (jumps), or have controls of another kind (the choice of an initial state).
  bool are_some(int knot) const { return !columns_of(knot).empty(); }
  /// The column of each control of such a knot.
  std::span<const int> columns_of(int knot) const { return phases_[problem_.knot(knot).phase]; }

  /// A row of the table, NaN for controls that the knot lacks. Knots that do not use a subset of
  /// the columns get `own`.
  Eigen::VectorXd row(int knot, const Eigen::VectorXd& own) const;
  /// Applies row() to each column of a matrix with one row per control.
  Eigen::MatrixXd rows(int knot, const Eigen::MatrixXd& own) const;
  /// Inverse of row(): the knot's own controls. A row of another length is returned unchanged.
  Eigen::VectorXd own(int knot, const Eigen::VectorXd& row) const;
  /// Applies own() to a list of a solution document.
  template <class Json>
  Json own_entries(int knot, const Json& list) const {
    if (!are_some(knot) || !list.is_array() || static_cast<int>(list.size()) != count())
      return list;
    Json own = Json::array();
    for (const int column : columns_of(knot)) own.push_back(list[column]);
    return own;
  }

 private:
  const ShootingProblem& problem_;
  std::vector<Column> columns_;
  std::vector<std::vector<int>> phases_;
};

}  // namespace conddp
