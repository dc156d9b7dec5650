#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ocp/problem/node_values.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Name of a node's constraint, with the prefix "terminal/" at the terminal node.
std::string constraint_name(const ShootingProblem& problem, const NodeConstraint& constraint);

/// Names of the compiled functions of systems and residuals that have failed so far, without
/// duplicates.
std::vector<std::string> failed_functions(const ShootingProblem& problem);

/// Cost of each named term at each node (N + 1 numbers), in order of first appearance; names of the
/// terminal node have the prefix "terminal/".
std::vector<std::pair<std::string, std::vector<double>>> costs_by_node(
    const ShootingProblem& problem, const NodeValues& values);

/// Cost of each named term summed over the nodes, in order of first appearance; names of the
/// terminal node have the prefix "terminal/".
std::vector<std::pair<std::string, double>> cost_by_name(const ShootingProblem& problem,
                                                         const NodeValues& values);

/// The largest violation of a named constraint over the nodes.
struct ConstraintViolation {
  std::string name;  ///< with the prefix "terminal/" at the terminal node
  double value;      ///< distance_to_set
  int node;          ///< −1 if satisfied everywhere
};
/// Violations by name in order of first appearance, from the values of all constraint rows. Control
/// bounds are not included.
std::vector<ConstraintViolation> violations_by_name(const ShootingProblem& problem,
                                                    const Eigen::VectorXd& values);

/// Violations of the soft constraints, which violations_by_name() does not contain, at a trajectory
/// and the values there.
std::vector<ConstraintViolation> soft_violations(const ShootingProblem& problem,
                                                 const Trajectory& trajectory,
                                                 const Eigen::VectorXd& values);

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
