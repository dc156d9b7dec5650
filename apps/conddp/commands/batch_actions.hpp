#pragma once

#include <string_view>

#include "arguments/batch_arguments.hpp"

namespace conddp {

// Actions of 'conddp batch'; each returns the exit status.

/// Writes the files of one item: its problem with all defaults and its solution.
int show_item(const BatchArguments& arguments);

/// Writes the page of a run, and the files of the linked items.
int report_batch(const BatchArguments& arguments);

/// 'conddp batch submit': submits a run to Slurm as an array of shards and a job that collects the
/// results, or with --dry-run prints both.
int submit_batch(const BatchArguments& arguments);

/// First command-line word that makes the process a worker of 'conddp batch'; the second is the
/// folder of the run. It is internal and absent from the help.
inline constexpr std::string_view kBatchWorker = "batch-worker";

/// Runs a worker that takes items from standard input.
int batch_worker(const char* run);

}  // namespace conddp
