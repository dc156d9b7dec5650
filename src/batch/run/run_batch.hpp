#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batch/plan/manifest.hpp"
#include "batch/results/shard_file.hpp"

namespace conddp {

/// The progress of a run.
struct BatchProgress {
  std::size_t items = 0;   ///< of the shard
  std::size_t before = 0;  ///< solved or failed before this process began
  std::size_t done = 0;    ///< solved or failed in this process
  std::size_t failed = 0;  ///< not solved, in total
  double elapsed_s = 0;    ///< of this process
};

struct BatchOptions {
  std::vector<std::string> worker_command;  ///< command of a process that calls serve_items()
  int workers = 1;
  int group = 8;  ///< maximum number of items sent to a worker in advance
  Shard shard;
  double budget_s = 0;  ///< items do not begin after this time; 0: no limit
  std::optional<std::vector<std::size_t>> only;  ///< items to solve; absent: all
  bool again = false;                            ///< solve even those with a result
  std::function<bool()> interrupted;             ///< items in progress are dropped
  std::function<bool()> stop_soon;               ///< items in progress are finished
  std::function<void(const BatchProgress&)> on_progress;
};

/// Solves the items of a run without a result in worker processes, and appends the results to the
/// shard's file. A worker that dies, or far exceeds the time limit, is replaced. Its current item
/// is retried alone as often as the plan allows, then recorded with the reason. Throws OutputError
/// if results cannot be written or a worker cannot be started.
BatchProgress run_batch(const std::filesystem::path& run, const Manifest& manifest,
                        const BatchOptions& options);

/// The items of a shard, by index, in the order of solution. Blocks of items that start from one
/// another stay together.
std::vector<std::size_t> items_of_shard(const Manifest& manifest, const Shard& shard);

}  // namespace conddp
