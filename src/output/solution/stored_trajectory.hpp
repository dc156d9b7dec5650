#pragma once

#include "base/json/ordered_json.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// The trajectory that the document of a solution holds; NaN for nulls. Throws MalformedSolution
/// where it has another shape than that of the problem.
Trajectory stored_trajectory(const OrderedJson& document, const ShootingProblem& problem);

}  // namespace conddp
