#include "systems/libraries/slope_interval.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace conddp {

SlopeInterval between_slopes(double a, double b) { return {std::min(a, b), std::max(a, b)}; }

SlopeInterval at_edge(double slope, double slope_of_quarter) {
  return between_slopes(slope, 2 * slope_of_quarter - slope);
}

double difference_step(double coordinate) {
  return std::cbrt(std::numeric_limits<double>::epsilon()) * std::max(1.0, std::abs(coordinate));
}

double confirmed_slope(double claimed, const SlopeInterval& interval, double slack) {
  const auto [lower, upper] = interval;
  if (!std::isfinite(lower) || !std::isfinite(upper))
    return std::numeric_limits<double>::quiet_NaN();
  if (lower - slack <= claimed && claimed <= upper + slack) return claimed;
  return std::isnan(claimed) ? 0.5 * (lower + upper) : std::clamp(claimed, lower, upper);
}

}  // namespace conddp
