#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "batch/plan/manifest.hpp"
#include "batch/results/shard_file.hpp"
#include "mpc/closed_loop.hpp"

namespace conddp {

/// An item as ordinary files have it.
struct ShownItem {
  std::unique_ptr<const ProblemSpec> spec;
  BuiltProblem built;
  std::filesystem::path file;  ///< its problem file
  OrderedJson document;        ///< solution.json; null where no solution is kept
};

/// Builds the problem of an item again. `stored`: its result, or null. Nothing with errors where
/// its files have changed since the plan was made, or its solution is damaged.
std::optional<ShownItem> load_item(const std::filesystem::path& run, const Manifest& manifest,
                                   const ManifestItem& item, const StoredResult* stored,
                                   Diagnostics& out);

/// A closed loop that was simulated again.
struct WrittenLoop {
  LoopEnd end = LoopEnd::finished;
  std::vector<std::filesystem::path> paths;
};

/// Builds the closed loop of an item again, simulates it without a limit of time, and writes
/// problem.yaml (every default, paths as seen from there) and the files of the loop into a folder,
/// all or none. Warns of what problem.yaml cannot say. Nothing with errors where the item's files
/// have changed since the plan was made.
std::optional<WrittenLoop> write_loop_item(const std::filesystem::path& run,
                                           const Manifest& manifest, const ManifestItem& item,
                                           const std::filesystem::path& folder, Diagnostics& out);

/// Writes problem.yaml (every default, paths as seen from there) and, where a solution is kept,
/// solution.json, trajectory.csv and iterations.csv into a folder, all or none. Returns their
/// paths. Throws OutputError, and MalformedSolution where the solution is not one of the problem.
std::vector<std::filesystem::path> write_item(const ShownItem& item,
                                              const std::filesystem::path& folder);

}  // namespace conddp
