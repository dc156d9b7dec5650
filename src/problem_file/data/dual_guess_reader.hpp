#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "base/text/diagnostic.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/common/dual_guess.hpp"

namespace conddp {

/// Multipliers of a former solution, with a description of the multipliers used.
struct DualGuessUsed {
  std::shared_ptr<const DualGuess> guess;  ///< null if no multipliers fit
  std::string text;
};

/// Reads the multipliers of a solution.json for a problem that may have changed since. Multipliers
/// of a constraint are used if it applies at the same nodes with the same number of rows; otherwise
/// the constraint is skipped. Multipliers of the dynamics and of control bounds are used if the
/// numbers of knots and controls agree. A file that is not a solution is reported at `place`.
std::optional<DualGuessUsed> read_dual_guess(const std::filesystem::path& file, const Place& place,
                                             const ShootingProblem& problem, Diagnostics& out);

}  // namespace conddp
