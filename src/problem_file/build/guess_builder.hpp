#pragma once

#include "ocp/problem/problem.hpp"
#include "problem_file/terms/reference_builder.hpp"

namespace conddp {

/// What the first trajectory was made from, in words, for the output.
struct GuessUsed {
  std::string states;
  std::string controls;
  std::string multipliers = "none";
  std::optional<std::uint64_t> seed;
};

/// What the guess needs besides the problem itself.
struct GuessContext {
  const ProblemSpec& spec;
  const Plant& plant;
  const StateBuilder& states;
  const ShootingProblem& problem;
};

/// The first trajectory. Its first state is the initial one; states between keyframes follow the
/// shortest way and need not obey the dynamics.
std::optional<Trajectory> build_guess(const GuessContext& context, GuessUsed& used,
                                      Diagnostics& out);

}  // namespace conddp
