#pragma once

#include <string_view>

namespace conddp {

/// The first word of a command line that makes the process a worker of 'conddp batch'; the second
/// is the folder of the run. It is not for users, and no help mentions it.
inline constexpr std::string_view kBatchWorker = "batch-worker";

/// The exit status of a worker that takes items from standard input.
int batch_worker(const char* run);

}  // namespace conddp
