#pragma once

#include "base/json/ordered_json.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// The trajectory in the document of a solution, NaN for nulls. Throws MalformedSolution if its
/// shape differs from that of the problem.
Trajectory stored_trajectory(const OrderedJson& document, const ShootingProblem& problem);

}  // namespace conddp
