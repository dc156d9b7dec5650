#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batch/plan/axis.hpp"
#include "problem_file/yaml/setting.hpp"

namespace conddp {

/// The format of plans that is read, the value of their key `conddp_batch`.
inline constexpr int kBatchFormat = 1;

/// Of which items the whole solution is kept, besides the row of results.
enum class KeptSolutions { kAll, kConverged, kNone };

/// What is done with an item: it is solved, or its closed loop is simulated.
enum class BatchCommand { kSolve, kMpc };

/// From where solves start: each from its own guess, from the answer of a neighbour, or all from a
/// file.
enum class WarmStart { kNone, kNeighbour, kFile };

/// What an item may use.
struct BatchLimits {
  double max_time_s = 0;  ///< of a solve or a loop; 0: what its problem says
  int max_memory_mb = 0;  ///< of a worker's data; 0: no limit
  int retries = 0;        ///< further attempts at an item whose worker died
};

/// A batch of problems: files, what is varied in them, and by which solvers they are solved.
struct BatchPlan {
  std::filesystem::path file;
  std::string text;
  Name name;
  BatchCommand command = BatchCommand::kSolve;
  std::vector<Located<std::filesystem::path>> problems;  ///< as seen from here
  std::vector<Axis> axes;
  std::vector<Name> solvers;  ///< empty: that of each problem
  BatchLimits limits;
  std::optional<Located<double>> max_time;  ///< limits.max_time_s with its place
  KeptSolutions keep = KeptSolutions::kConverged;
  WarmStart warm_start = WarmStart::kNone;
  std::optional<Located<std::filesystem::path>> start_file;  ///< of WarmStart::kFile

  /// Problems times rows of all axes times solvers.
  long long items() const;
};

/// Columns of results.csv that say how a closed loop went.
inline constexpr std::string_view kLoopColumns[] = {"time_s", "planned",   "fallback",
                                                    "cost",   "violation", "message"};

/// Whether results.csv has a column of this name besides those of what is varied.
bool is_column_of_results(std::string_view name, BatchCommand command, WarmStart warm_start);

/// Reads a plan. Everything wrong is in `out` with its place; then nothing is returned.
std::optional<BatchPlan> load_batch_plan(const std::filesystem::path& file, Diagnostics& out);

}  // namespace conddp
