#pragma once

#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// "knot 12 (phase 'swing'), v/elbow"; the last part is omitted if `quantity` is empty.
std::string place_text(const ShootingProblem& problem, int knot, const std::string& quantity);

/// Name of a control at its knot. The controls of a free initial state are its components. Empty if
/// the control does not exist or is not named.
std::string control_name(const ShootingProblem& problem, int knot, int entry);

}  // namespace conddp
