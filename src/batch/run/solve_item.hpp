#pragma once

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

/// Builds, solves and certifies one item, with one thread. `from`: an answer to start from, or
/// null.
SolvedItem solve_item(const ManifestItem& item, const Manifest& manifest,
                      const ProblemFamily& family, const NeighbourAnswer* from);

}  // namespace conddp
