#pragma once

#include <algorithm>

#include "solvers/common/tuning.hpp"

namespace conddp {

/// The weight μ of the sweep's regularization, adapted by Tassa's quadratic schedule (Tassa, Erez,
/// Todorov 2012, section II-F). Every change in the same direction multiplies the rate of change,
/// so that a few trials cover many decades. From zero, μ rises to the smallest positive value;
/// below that value, it returns to zero.
class RegularizationSchedule {
 public:
  explicit RegularizationSchedule(double initial = 0) : value_(initial) {}

  double value() const { return value_; }
  /// False, without a change, if μ is already at its largest value.
  bool increase();
  void decrease();
  /// Lowers the smallest positive value to at most this one.
  void lower_min(double min) { min_ = std::min(min_, min); }

 private:
  double value_;
  double min_ = tuning::kLeastRegularization;
  double rate_ = 1;
};

}  // namespace conddp
