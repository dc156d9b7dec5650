#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// Options for a guess that nearly satisfies the constraints: the first penalty holds them.
SolverOptions options_near(const SolverOptions& options);

/// Calls `solve`. If the guess satisfies all constraints and the end is worse (a violation or a
/// larger cost), solves again from the guess. These solves have larger first penalties, if the
/// solver has any (`penalizes`). If that does not help, the answer is the guess, with status
/// `line_search_failed`, or `max_iterations` if these are used up. Ends by time, a signal or
/// divergence are returned unchanged. Limits cover all solves together.
SolveResult solve_keeping_guess(
    const SolverOptions& options, const Trajectory& guess, bool penalizes,
    const std::function<SolveResult(const SolverOptions&, const Trajectory&)>& solve);

}  // namespace conddp
