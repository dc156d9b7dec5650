#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "batch/plan/manifest.hpp"
#include "batch/results/result.hpp"
#include "batch/run/warm_solve.hpp"

namespace conddp {

/// A result, and the whole solution.json as packed_document() where it is kept.
struct SolvedItem {
  ItemResult result;
  std::string solution;
  std::optional<NeighbourAnswer> answer;  ///< of an item that is solved
};

/// The settings of an item.
std::vector<Setting> settings_of(const ManifestItem& item, Diagnostics& out);

/// The result of an item that cannot be built any more, in the words of the first error.
ItemResult not_built(const ManifestItem& item, const Diagnostics& diagnostics);

/// From where an item starts, where that is not its own guess.
struct ItemStart {
  const NeighbourAnswer* neighbour = nullptr;
  std::optional<std::filesystem::path> file;  ///< the plan's, as seen from here
};

/// Builds, solves and certifies one item, with one thread.
SolvedItem solve_item(const ManifestItem& item, const Manifest& manifest,
                      const ProblemFamily& family, const ItemStart& start);

}  // namespace conddp
