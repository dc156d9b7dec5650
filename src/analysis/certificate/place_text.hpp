#pragma once

#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// "knot 12 (phase 'swing'), v/elbow"; the last part only where there is a name.
std::string place_text(const ShootingProblem& problem, int knot, const std::string& quantity);

}  // namespace conddp
