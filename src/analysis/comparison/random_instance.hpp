#pragma once

#include <cstdint>

#include "ocp/problem/problem.hpp"
#include "solvers/common/options.hpp"

namespace conddp {

/// What a user may ask for: of spreads, and of seeds.
inline constexpr double kLargestSpread = 1e6;
inline constexpr long long kLargestSeed = 1'000'000'000;

/// One of many instances of a problem.
struct Perturbation {
  double initial_state = 0;  ///< largest entry of the tangent vector that moves it
  double guess = 0;          ///< standard deviation of what is added to states and controls
  std::uint64_t seed = 1;

  bool any() const { return initial_state > 0 || guess > 0; }
};

/// The problem with another initial state: x₀ ⊕ δ with entries of δ drawn from the uniform
/// distribution on [−size, size], each in its own unit (m, rad, m/s, rad/s). Remembered controls
/// stay. Costs and their references stay too, those that name the initial state included. The same
/// seed gives the same instance with every standard library.
ShootingProblem perturb_initial_state(const ShootingProblem& problem, double size,
                                      std::uint64_t seed);

/// The same of every problem on the way of a homotopy, if there is one.
ProblemPath perturb_initial_state(ProblemPath homotopy, double size, std::uint64_t seed);

/// The guess of an instance, from that of its problem: perturb_guess, from its initial state.
Trajectory guess_of_instance(const ShootingProblem& instance, const Trajectory& guess,
                             const Perturbation& perturbation);

}  // namespace conddp
