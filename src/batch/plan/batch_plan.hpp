#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batch/plan/axis.hpp"
#include "problem_file/yaml/setting.hpp"

namespace conddp {

/// The supported format of plans, the value of their key `conddp_batch`.
inline constexpr int kBatchFormat = 1;

/// Items with a stored solution in addition to their row of results.
enum class KeptSolutions { kAll, kConverged, kNone };

/// The operation on an item: solve it, or simulate its closed loop.
enum class BatchCommand { kSolve, kMpc };

/// The starting point of solves: each item's own guess, the answer of a neighbor, or a file for
/// all.
enum class WarmStart { kNone, kNeighbour, kFile };

/// Resource limits of an item.
struct BatchLimits {
  double max_time_s = 0;  ///< of a solve or a loop; 0: the problem's own limit
  int max_memory_mb = 0;  ///< for a worker's data; 0: unlimited
  int retries = 0;        ///< number of further attempts after a worker died
};

/// A batch of problems: files, their variations, and solvers.
struct BatchPlan {
  std::filesystem::path file;
  std::string text;
  Name name;
  BatchCommand command = BatchCommand::kSolve;
  std::vector<Located<std::filesystem::path>> problems;  ///< relative to the working directory
  std::vector<Axis> axes;
  std::vector<Name> solvers;  ///< empty: each problem's own
  BatchLimits limits;
  std::optional<Located<double>> max_time;  ///< limits.max_time_s with its place
  KeptSolutions keep = KeptSolutions::kConverged;
  WarmStart warm_start = WarmStart::kNone;
  std::optional<Located<std::filesystem::path>> start_file;  ///< for WarmStart::kFile

  /// Number of problems times rows of all axes times solvers.
  long long items() const;
};

/// Columns of results.csv that describe a closed loop.
inline constexpr std::string_view kLoopColumns[] = {"time_s", "planned",   "fallback",
                                                    "cost",   "violation", "message"};

/// True if results.csv has a column of this name besides the varied ones.
bool is_column_of_results(std::string_view name, BatchCommand command, WarmStart warm_start);

/// Reads a plan. Reports all errors with their places in `out`, and then returns nothing.
std::optional<BatchPlan> load_batch_plan(const std::filesystem::path& file, Diagnostics& out);

}  // namespace conddp
