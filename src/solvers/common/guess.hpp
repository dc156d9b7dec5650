#pragma once

#include <cstdint>
#include <string>

#include "ocp/problem/problem.hpp"
#include "solvers/common/control_bounds.hpp"

namespace conddp {

/// Throws std::invalid_argument if a guess differs from the problem in the number of knots, states
/// or controls.
void check_shape(const ShootingProblem& problem, const Trajectory& guess);

/// Projects the controls onto their bounds. Here and below, changes are reported at the end of
/// `start`, the sentence SolveResult::start.
void clamp_guess(const ControlBounds& bounds, Trajectory& trajectory, std::string& start);

/// Sets x_0 to the problem's initial state and normalizes the quaternions of all states. Throws
/// std::invalid_argument if a quaternion is far from unit length.
void correct_states(const ShootingProblem& problem, Trajectory& trajectory, std::string& start);

/// A randomly perturbed guess. Adds normal numbers of standard deviation `spread` to every tangent
/// coordinate of the states after the first and to every control, each in its own unit. The same
/// seed gives the same guess with every standard library.
Trajectory perturb_guess(const ShootingProblem& problem, const Trajectory& guess, double spread,
                         std::uint64_t seed);

}  // namespace conddp
