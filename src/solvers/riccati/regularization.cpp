#include "solvers/riccati/regularization.hpp"

#include <algorithm>

#include "solvers/common/options.hpp"

namespace conddp {
namespace {

/// Factor by which the rate of change grows or shrinks with each change, as Tassa's.
constexpr double kFactor = 2;
constexpr double kLargest = SolverOptions::Regularization::kLargest;

}  // namespace

bool RegularizationSchedule::increase() {
  if (value_ >= kLargest) return false;
  rate_ = std::max(kFactor, rate_ * kFactor);
  value_ = std::clamp(value_ * rate_, min_, kLargest);
  return true;
}

void RegularizationSchedule::decrease() {
  rate_ = std::min(1 / kFactor, rate_ / kFactor);
  value_ *= rate_;
  if (value_ < min_) value_ = 0;
}

}  // namespace conddp
