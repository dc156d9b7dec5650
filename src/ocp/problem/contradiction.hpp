#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Two constraints that leave a coordinate of a node without any feasible value. `second` is empty
/// if it stands for the control bounds.
struct Contradiction {
  std::string first, second;
  int node;
  double lower, upper;  ///< of the coordinate, in the units of the first constraint
};

/// The first contradiction among bounds on single coordinates of states and controls. Rows must be
/// affine in one coordinate; their slopes convert their bounds into bounds on the coordinate. At
/// the first node, the state is known, so rows may also combine it with one control. Other rows are
/// not examined; their contradictions are left to the solvers.
std::optional<Contradiction> find_contradiction(const ShootingProblem& problem);

}  // namespace conddp
