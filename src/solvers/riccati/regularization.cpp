#include "solvers/riccati/regularization.hpp"

#include <algorithm>

namespace conddp {

bool RegularizationSchedule::increase() {
  if (value_ >= options_.max) return false;
  rate_ = std::max(options_.factor, rate_ * options_.factor);
  value_ = std::clamp(value_ * rate_, options_.min, options_.max);
  return true;
}

void RegularizationSchedule::decrease() {
  rate_ = std::min(1 / options_.factor, rate_ / options_.factor);
  value_ *= rate_;
  if (value_ < options_.min) value_ = 0;
}

}  // namespace conddp
