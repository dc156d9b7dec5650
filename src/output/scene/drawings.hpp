#pragma once

#include <span>

#include "base/json/ordered_json.hpp"
#include "ocp/problem/trajectory.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Adds the drawings of a problem's file to a scene of motion_scene() along a trajectory. `knots`:
/// the problem's knot at each node; empty: the nodes are those of the problem.
void add_drawings(const BuiltProblem& built, const Trajectory& trajectory,
                  std::span<const int> knots, OrderedJson& scene);

}  // namespace conddp
