#pragma once

#include <functional>

namespace conddp {

/// Calls task(0) … task(count − 1) in up to `threads` threads, including the calling one. Each
/// thread takes the next number; after a task returns false or throws, no further numbers are
/// taken. When all threads have ended, the first exception is rethrown.
void run_tasks(int count, int threads, const std::function<bool(int)>& task);

}  // namespace conddp
