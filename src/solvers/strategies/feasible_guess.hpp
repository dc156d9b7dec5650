#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// Options from a guess that all but satisfies the constraints: the first penalty holds them.
SolverOptions options_near(const SolverOptions& options);

/// Solves by `solve`; where the guess satisfies all constraints and the end is worse, with a
/// violation or a larger cost, again from the guess with larger first penalties, if the solver has
/// any (`penalizes`). Where that does not help the answer is the guess, as `line_search_failed`, or
/// as `max_iterations` where these are used up. Ends by time, a signal or divergence stay what they
/// are. Limits are of all together.
SolveResult solve_keeping_guess(
    const SolverOptions& options, const Trajectory& guess, bool penalizes,
    const std::function<SolveResult(const SolverOptions&, const Trajectory&)>& solve);

}  // namespace conddp
