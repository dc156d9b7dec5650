#pragma once

#include "base/json/ordered_json.hpp"
#include "ocp/problem/trajectory.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Values and violations of all constraints except control bounds along a trajectory: a list with
/// one entry per name. Names of the last node begin with "terminal/"; names of omitted constraints
/// end with " (left out)". An entry has:
///   name; first: the first node of the constraint;
///   violation: distance from the set, the maximum if several constraints share the name, for
///     each node from its first to its last one (null if absent at a node);
///   margin: true if rows are the distance from the nearest bound, negative outside, instead of
///     the values: for cones, and if several constraints share the name;
///   rows: for each row its name, and values, lower and upper for the same nodes (null if
///     unbounded; one number if all nodes have the same one).
OrderedJson constraint_curves(const BuiltProblem& built, const Trajectory& trajectory);

}  // namespace conddp
