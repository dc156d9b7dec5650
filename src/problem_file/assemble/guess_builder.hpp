#pragma once

#include "ocp/problem/problem.hpp"
#include "problem_file/terms/reference_builder.hpp"

namespace conddp {

/// Description of the sources of the initial guess, for the output.
struct GuessUsed {
  std::string states;
  std::string controls;
  std::string multipliers = "none";
  std::optional<std::uint64_t> seed;
};

/// Inputs of the guess.
struct GuessContext {
  const ProblemSpec& spec;
  const Plant& plant;
  const StateBuilder& states;
  const ShootingProblem& problem;
};

/// Builds the initial guess. Its first state is the initial state. States between keyframes follow
/// the shortest path and need not satisfy the dynamics.
std::optional<Trajectory> build_guess(const GuessContext& context, GuessUsed& used,
                                      Diagnostics& out);

}  // namespace conddp
