#pragma once

#include <functional>

namespace conddp {

/// Calls task(0) … task(count − 1) in up to `threads` threads, of which this one is the first. Each
/// thread takes the next number; none is taken once task has returned false or thrown. The first
/// exception is thrown again here when all threads have ended.
void run_tasks(int count, int threads, const std::function<bool(int)>& task);

}  // namespace conddp
