#pragma once

#include "arguments/batch_arguments.hpp"

namespace conddp {

/// 'conddp batch submit': submits a run to Slurm as an array of shards and a job that collects the
/// results, or with --dry-run prints both. Returns the exit status.
int submit_batch(const BatchArguments& arguments);

}  // namespace conddp
