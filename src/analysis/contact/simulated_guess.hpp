#pragma once

#include <optional>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Simulation of a contact-implicit problem by ContactSimulator from the guess's first state, under
/// the guess's actuator controls: states, accelerations, forces and slacks of every step satisfy
/// the stepping equations and their complementarity. Nothing for other problems, and where a step
/// has no solution.
std::optional<Trajectory> simulated_guess(const ShootingProblem& problem, const Trajectory& guess);

}  // namespace conddp
