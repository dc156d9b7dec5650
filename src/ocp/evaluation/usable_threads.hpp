#pragma once

#include <algorithm>

#include <tbb/global_control.h>

namespace conddp {

/// Number of threads, at most `wanted` and at least 1, that this process gets from TBB. An arena
/// for more threads would gain nothing, and TBB would print a warning on stderr.
inline int usable_threads(int wanted) {
  using tbb::global_control;
  const auto most = global_control::active_value(global_control::max_allowed_parallelism);
  return std::clamp(wanted, 1, std::max(1, static_cast<int>(most)));
}

}  // namespace conddp
