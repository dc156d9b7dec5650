#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "batch/plan/manifest.hpp"
#include "batch/results/shard_file.hpp"
#include "mpc/closed_loop.hpp"

namespace conddp {

/// An item in the form of ordinary problem and solution files.
struct ShownItem {
  BuiltProblem built;
  OrderedJson document;  ///< solution.json; null without a stored solution
};

/// Rebuilds the problem of an item. `stored` is its result, or null. Nothing, with errors, if its
/// files have changed since planning or its solution is damaged.
std::optional<ShownItem> load_item(const std::filesystem::path& run, const Manifest& manifest,
                                   const ManifestItem& item, const StoredResult* stored,
                                   Diagnostics& out);

/// A re-simulated closed loop.
struct WrittenLoop {
  LoopEnd end = LoopEnd::finished;
  std::vector<std::filesystem::path> paths;
};

/// Rebuilds the closed loop of an item, simulates it without a time limit, and writes problem.yaml
/// (with every default, and paths relative to the folder) and the files of the loop. Writes all
/// files or none. Warns about settings that problem.yaml cannot express. Nothing, with errors, if
/// the item's files have changed since planning.
std::optional<WrittenLoop> write_loop_item(const std::filesystem::path& run,
                                           const Manifest& manifest, const ManifestItem& item,
                                           const std::filesystem::path& folder, Diagnostics& out);

/// Writes problem.yaml (with every default, and paths relative to the folder) and, if a solution is
/// stored, solution.json, trajectory.csv and iterations.csv. Writes all files or none, and returns
/// their paths. Throws OutputError, and MalformedSolution if the solution does not match the
/// problem.
std::vector<std::filesystem::path> write_item(const ShownItem& item,
                                              const std::filesystem::path& folder);

}  // namespace conddp
