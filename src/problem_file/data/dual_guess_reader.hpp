#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "base/text/diagnostic.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/common/dual_guess.hpp"

namespace conddp {

/// Multipliers of a former solution, and what of them is used, in words.
struct DualGuessUsed {
  std::shared_ptr<const DualGuess> guess;  ///< null where nothing of them fits
  std::string text;
};

/// Reads the multipliers of a solution.json for a problem that may have changed since. Those of a
/// constraint are taken where it holds at the same nodes with as many rows as then, and its name
/// is left out otherwise; those of the dynamics and of bounds on the control where the knots and
/// their controls are as many. What is no solution is reported at `place`.
std::optional<DualGuessUsed> read_dual_guess(const std::filesystem::path& file, const Place& place,
                                             const ShootingProblem& problem, Diagnostics& out);

}  // namespace conddp
