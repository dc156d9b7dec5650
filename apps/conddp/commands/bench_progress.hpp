#pragma once

#include <chrono>
#include <string>

namespace conddp {

/// How much of a benchmark is done, how fast, and when the rest will be, if that takes as long on
/// average. Refusals take no time and do not count.
class BenchProgress {
 public:
  /// `runs` there will be.
  explicit BenchProgress(int runs) : runs_(runs) {}

  /// One more is done.
  void count() { ++done_; }
  /// "3 of 20, about 40 s left, 2.5 solves/s"
  std::string text() const;

 private:
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  const int runs_;
  int done_ = 0;
};

}  // namespace conddp
