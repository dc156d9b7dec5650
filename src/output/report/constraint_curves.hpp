#pragma once

#include "base/json/ordered_json.hpp"
#include "ocp/problem/trajectory.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// Values and violations of all constraints but bounds on the control along a trajectory, a list
/// with one entry a name (those of the last node begin with "terminal/", those that were left out
/// end with " (left out)"):
///   name; first: the first node that it holds at;
///   violation: distance from the set, the largest where several constraints share the name, for
///     each node from the first to the last one that it holds at (null where it does not);
///   margin: whether rows are the distance from the nearest bound, negative outside, instead of the
///     values: of cones, and where several constraints share the name;
///   rows: of each row its name, and values, lower and upper for the same nodes (null where there
///     is no bound; one number where all nodes have the same one).
OrderedJson constraint_curves(const ProblemSpec& spec, const BuiltProblem& built,
                              const Trajectory& trajectory);

}  // namespace conddp
