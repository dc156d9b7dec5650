#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batch/plan/manifest.hpp"
#include "batch/results/shard_file.hpp"

namespace conddp {

/// How far a run is.
struct BatchProgress {
  std::size_t items = 0;   ///< of the shard
  std::size_t before = 0;  ///< of these, solved or failed before this process began
  std::size_t done = 0;    ///< of these, solved or failed now
  std::size_t failed = 0;  ///< of all these, not solved
  double elapsed_s = 0;    ///< of this process
};

struct BatchOptions {
  std::vector<std::string> worker_command;  ///< a process that calls serve_items()
  int workers = 1;
  int group = 8;  ///< items that are sent to a worker ahead
  Shard shard;
  double budget_s = 0;                           ///< no item begins after this time; 0: no limit
  std::optional<std::vector<std::size_t>> only;  ///< items to solve; absent: all
  bool again = false;                            ///< also those that have a result
  std::function<bool()> interrupted;             ///< items under way are dropped
  std::function<bool()> stop_soon;               ///< items under way are finished
  std::function<void(const BatchProgress&)> on_progress;
};

/// Solves the items of a run that have no result yet, in worker processes, and appends their
/// results to the file of the shard. A worker that dies, or exceeds the limit of time by far, is
/// replaced; the item that it had begun is tried again alone as often as the plan allows, then
/// recorded with the reason. Throws OutputError where results cannot be written or no worker can
/// be started.
BatchProgress run_batch(const std::filesystem::path& run, const Manifest& manifest,
                        const BatchOptions& options);

/// The items of a shard, by their numbers, in the order in which they are solved: blocks of items
/// that start from one another stay together.
std::vector<std::size_t> items_of_shard(const Manifest& manifest, const Shard& shard);

}  // namespace conddp
