#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Two constraints on one coordinate of a node that leave it no value. `second` is empty where the
/// bounds on the control are the other one.
struct Contradiction {
  std::string first, second;
  int node;
  double lower, upper;  ///< of the coordinate, as the first constraint measures it
};

/// The first contradiction among bounds on single coordinates of states and controls: rows that are
/// affine in one coordinate, whose slope turns their bounds into the coordinate's; at the first
/// node, whose state is known, in one control and any states. Other rows prove nothing here:
/// solvers find what they contradict.
std::optional<Contradiction> find_contradiction(const ShootingProblem& problem);

}  // namespace conddp
