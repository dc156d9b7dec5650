#include "solvers/riccati/regularization.hpp"

#include <algorithm>

#include "solvers/common/options.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {

bool RegularizationSchedule::increase() {
  if (value_ >= SolverOptions::Regularization::kLargest) return false;
  rate_ = std::max(tuning::kRegularizationFactor, rate_ * tuning::kRegularizationFactor);
  value_ = std::clamp(value_ * rate_, min_, SolverOptions::Regularization::kLargest);
  return true;
}

void RegularizationSchedule::decrease() {
  rate_ = std::min(1 / tuning::kRegularizationFactor, rate_ / tuning::kRegularizationFactor);
  value_ *= rate_;
  if (value_ < min_) value_ = 0;
}

}  // namespace conddp
