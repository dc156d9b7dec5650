#pragma once

#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// "knot 12 (phase 'swing'), v/elbow"; the last part only where there is a name.
std::string place_text(const ShootingProblem& problem, int knot, const std::string& quantity);

/// What a control is called at its knot: where the first state is chosen they are components of
/// that. Empty where there is none, or it has no name.
std::string control_name(const ShootingProblem& problem, int knot, int entry);

}  // namespace conddp
