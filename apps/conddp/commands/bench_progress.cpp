#include "commands/bench_progress.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace conddp {
namespace {

/// Examples: "40 s", "3 min".
std::string about(double seconds) {
  return seconds < 90 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.0f} min", seconds / 60);
}

/// Examples: "2.5 solves/s", "12 solves/min".
std::string rate(double per_second) {
  return per_second >= 1 ? fmt::format("{:.1f} solves/s", per_second)
                         : fmt::format("{:.1f} solves/min", 60 * per_second);
}

}  // namespace

std::string BenchProgress::text() const {
  const std::string place = fmt::format("{} of {}", std::min(done_ + 1, runs_), runs_);
  if (done_ == 0) return place;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  return fmt::format("{}, about {} left, {}", place,
                     about(elapsed.count() / done_ * (runs_ - done_)),
                     rate(done_ / elapsed.count()));
}

}  // namespace conddp
