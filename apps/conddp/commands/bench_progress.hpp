#pragma once

#include <chrono>
#include <string>

namespace conddp {

/// Progress and speed of a benchmark, and an estimate of the remaining time at the average speed.
/// Unsupported problems take no time and are not counted.
class BenchProgress {
 public:
  /// `runs`: total number of runs.
  explicit BenchProgress(int runs) : runs_(runs) {}

  /// Counts a finished run.
  void count() { ++done_; }
  /// Example: "3 of 20, about 40 s left, 2.5 solves/s".
  std::string text() const;

 private:
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  const int runs_;
  int done_ = 0;
};

}  // namespace conddp
