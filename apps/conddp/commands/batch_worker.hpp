#pragma once

#include <string_view>

namespace conddp {

/// First command-line word that makes the process a worker of 'conddp batch'; the second is the
/// folder of the run. It is internal and absent from the help.
inline constexpr std::string_view kBatchWorker = "batch-worker";

/// Runs a worker that takes items from standard input. Returns its exit status.
int batch_worker(const char* run);

}  // namespace conddp
