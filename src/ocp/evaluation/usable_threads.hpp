#pragma once

#include <algorithm>

#include <tbb/global_control.h>

namespace conddp {

/// How many of `wanted` threads this process gets from TBB, at least 1. An arena for more of them
/// would get no more, and TBB would say so on stderr.
inline int usable_threads(int wanted) {
  using tbb::global_control;
  const auto most = global_control::active_value(global_control::max_allowed_parallelism);
  return std::clamp(wanted, 1, std::max(1, static_cast<int>(most)));
}

}  // namespace conddp
