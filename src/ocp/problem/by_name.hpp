#pragma once

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

}  // namespace conddp
