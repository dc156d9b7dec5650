#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "batch/plan/manifest.hpp"
#include "batch/results/result.hpp"
#include "batch/run/warm_solve.hpp"

namespace conddp {

/// A result and, if it is stored, the complete solution.json as packed_document().
struct SolvedItem {
  ItemResult result;
  std::string solution;
  std::optional<NeighbourAnswer> answer;  ///< if the item is solved
};

/// The result of an item that can no longer be built, with the message of the first error.
ItemResult not_built(const ManifestItem& item, const Diagnostics& diagnostics);

/// The starting point of an item, if it is not its own guess.
struct ItemStart {
  const NeighbourAnswer* neighbour = nullptr;
  std::optional<std::filesystem::path> file;  ///< the plan's file, from the working directory
};

/// Builds, solves and certifies an item in one thread.
SolvedItem solve_item(const ManifestItem& item, const Manifest& manifest,
                      const ProblemFamily& family, const ItemStart& start);

/// Builds the closed loop of an item and simulates it in one thread. The status says how the loop
/// ended. A loop that exceeds the time limit ends at its next tick.
SolvedItem simulate_item(const ManifestItem& item, const Manifest& manifest,
                         const ProblemFamily& family);

}  // namespace conddp
