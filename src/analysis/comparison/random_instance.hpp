#pragma once

#include <cstdint>

#include "ocp/problem/problem.hpp"
#include "solvers/common/options.hpp"

namespace conddp {

/// Largest spread and seed that a user may set.
inline constexpr double kLargestSpread = 1e6;
inline constexpr long long kLargestSeed = 1'000'000'000;

/// One of many instances of a problem.
struct Perturbation {
  double initial_state = 0;  ///< largest entry of the tangent vector that displaces it
  double guess = 0;          ///< standard deviation of the noise on states and controls
  std::uint64_t seed = 1;

  bool any() const { return initial_state > 0 || guess > 0; }
};

/// The problem with another initial state x₀ ⊕ δ. Entries of δ are drawn uniformly from [−size,
/// size], each in its own unit (m, rad, m/s, rad/s). Remembered controls stay the same, and so do
/// costs and their references, even those that name the initial state. The same seed gives the same
/// instance with every standard library.
ShootingProblem perturb_initial_state(const ShootingProblem& problem, double size,
                                      std::uint64_t seed);

/// The same for every problem of a homotopy, which may be empty.
ProblemPath perturb_initial_state(ProblemPath homotopy, double size, std::uint64_t seed);

/// Guess of an instance from that of its problem: perturb_guess, starting at its initial state.
Trajectory guess_of_instance(const ShootingProblem& instance, const Trajectory& guess,
                             const Perturbation& perturbation);

}  // namespace conddp
