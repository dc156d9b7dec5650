#pragma once

#include <cstdint>
#include <string>

#include "ocp/problem/problem.hpp"
#include "solvers/common/control_bounds.hpp"

namespace conddp {

/// Throws std::invalid_argument where a guess has not the problem's number of knots, states and
/// controls.
void check_shape(const ShootingProblem& problem, const Trajectory& guess);

/// Projects the controls on their bounds. Here and below, changes are told at the end of `start`,
/// the sentence SolveResult::start.
void clamp_guess(const ControlBounds& bounds, Trajectory& trajectory, std::string& start);

/// Puts x_0 where the problem has it and the quaternions of all states on the unit sphere. Throws
/// std::invalid_argument where one is far from it.
void correct_states(const ShootingProblem& problem, Trajectory& trajectory, std::string& start);

/// A guess with random numbers added: normal ones of standard deviation `spread` to every tangent
/// coordinate of the states past the first and to every control, each in its own unit. The same
/// seed gives the same guess with every standard library.
Trajectory perturb_guess(const ShootingProblem& problem, const Trajectory& guess, double spread,
                         std::uint64_t seed);

}  // namespace conddp
