#pragma once

#include <span>
#include <vector>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Where the controls of each knot stand in tables of all controls of a problem, whose columns are
/// those of all phases that take time, in the order in which they first appear.
class ControlColumns {
 public:
  explicit ControlColumns(const ShootingProblem& problem);

  int count() const { return static_cast<int>(columns_.size()); }
  const std::vector<Column>& columns() const { return columns_; }
  /// Whether the controls of a knot stand in some of the columns alone. Other knots have all of
  /// them in order, or none (jumps), or controls of another kind (the choice of a first state).
  bool are_some(int knot) const { return !columns_of(knot).empty(); }
  /// The column of each control of such a knot.
  std::span<const int> columns_of(int knot) const { return phases_[problem_.knot(knot).phase]; }

  /// The row of a table: NaN where the knot has no control. Other knots have the row `own`.
  Eigen::VectorXd row(int knot, const Eigen::VectorXd& own) const;
  /// The same for a matrix with a row for each control.
  Eigen::MatrixXd rows(int knot, const Eigen::MatrixXd& own) const;
  /// The inverse: the numbers of the knot's own controls. A row of another length is as it is.
  Eigen::VectorXd own(int knot, const Eigen::VectorXd& row) const;
  /// The same of a list of the document of a solution.
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
