#pragma once

#include <string>
#include <utility>
#include <vector>

#include "ocp/problem/node_values.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// What a node's constraint is called: its name, with the prefix "terminal/" at the terminal node.
std::string constraint_name(const ShootingProblem& problem, const NodeConstraint& constraint);

/// The compiled functions of systems and residuals that have reported failure so far, each once.
std::vector<std::string> failed_functions(const ShootingProblem& problem);

/// The cost of each named term at each node (N + 1 numbers), in the order of first appearance;
/// names of the terminal node get the prefix "terminal/".
std::vector<std::pair<std::string, std::vector<double>>> costs_by_node(
    const ShootingProblem& problem, const NodeValues& values);

/// The cost of each named term summed over the knots, in the order of first appearance; names of
/// the terminal node get the prefix "terminal/".
std::vector<std::pair<std::string, double>> cost_by_name(const ShootingProblem& problem,
                                                         const NodeValues& values);

/// How far a named constraint is from holding, at the node where that is most.
struct ConstraintViolation {
  std::string name;  ///< with the prefix "terminal/" at the terminal node
  double value;      ///< distance_to_set
  int node;          ///< −1 where it holds everywhere
};
/// Violations by name in the order of first appearance, from the values of all constraint rows.
/// Bounds on the control are not among them.
std::vector<ConstraintViolation> violations_by_name(const ShootingProblem& problem,
                                                    const Eigen::VectorXd& values);

/// The same of soft constraints, which are not among those, at a trajectory and the values there.
std::vector<ConstraintViolation> soft_violations(const ShootingProblem& problem,
                                                 const Trajectory& trajectory,
                                                 const Eigen::VectorXd& values);

}  // namespace conddp
