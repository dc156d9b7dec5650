#pragma once

#include "arguments/batch_arguments.hpp"

namespace conddp {

/// 'conddp batch submit': hands a run to Slurm as an array of shards and a job that collects, or
/// with --dry-run prints what it would hand over. Returns the exit status.
int submit_batch(const BatchArguments& arguments);

}  // namespace conddp
