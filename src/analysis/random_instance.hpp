#pragma once

#include <cstdint>

#include "ocp/problem.hpp"

namespace conddp {

/// The problem with another initial state: x₀ ⊕ δ with entries of δ drawn from the uniform
/// distribution on [−size, size], each in its own unit (m, rad, m/s, rad/s). Remembered controls
/// stay. Costs and their references stay too, those that name the initial state included. The same
/// seed gives the same instance with every standard library.
ShootingProblem perturb_initial_state(const ShootingProblem& problem, double size,
                                      std::uint64_t seed);

}  // namespace conddp
