#pragma once

#include <algorithm>

#include "solvers/common/options.hpp"

namespace conddp {

/// The weight μ of the sweep's regularisation, changed by Tassa's quadratic schedule (Tassa, Erez,
/// Todorov 2012, section II-F): every change in one direction multiplies the rate of change, so
/// that a good μ is found within a few trials over many decades. Zero is left for the smallest
/// positive value and reached again below it.
class RegularizationSchedule {
 public:
  explicit RegularizationSchedule(const SolverOptions::Regularization& options)
      : options_(options), value_(options.initial) {}

  double value() const { return value_; }
  /// False, without a change, where μ is at its largest value already.
  bool increase();
  void decrease();
  /// Makes the smallest positive value at most this one.
  void lower_min(double min) { options_.min = std::min(options_.min, min); }

 private:
  SolverOptions::Regularization options_;
  double value_;
  double rate_ = 1;
};

}  // namespace conddp
