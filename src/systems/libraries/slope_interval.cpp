#include "systems/libraries/slope_interval.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace conddp {
namespace {

double centre(const SlopeInterval& interval) { return 0.5 * (interval.lower + interval.upper); }

/// Infinite without finite slopes to compare.
double uncertainty(std::span<const MeasuredSlope> steps, std::size_t i) {
  const auto& [interval, noise] = steps[i];
  double sum = interval.upper - interval.lower + 2 * noise;
  if (i + 1 < steps.size()) sum += std::abs(centre(interval) - centre(steps[i + 1].interval));
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

}  // namespace

SlopeInterval between_slopes(double a, double b) { return {std::min(a, b), std::max(a, b)}; }

SlopeInterval at_edge(double slope, double slope_of_quarter) {
  return between_slopes(slope, 2 * slope_of_quarter - slope);
}

double difference_step(double coordinate) {
  return std::cbrt(std::numeric_limits<double>::epsilon()) * std::max(1.0, std::abs(coordinate));
}

bool confirms_slope(double of_shorter, double of_longer, double value_per_step) {
  constexpr double kPart = 1e-6, kRounding = 16 * std::numeric_limits<double>::epsilon();
  const double size = std::max(std::abs(of_shorter), std::abs(of_longer));
  return std::abs(of_shorter - of_longer) <= kPart * size + kRounding * value_per_step;
}

const MeasuredSlope& best_measured(std::span<const MeasuredSlope> steps) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < steps.size(); ++i)
    if (uncertainty(steps, i) < uncertainty(steps, best)) best = i;
  return steps[best];
}

double confirmed_slope(double claimed, const SlopeInterval& interval, double slack) {
  const auto [lower, upper] = interval;
  if (!std::isfinite(lower) || !std::isfinite(upper))
    return std::numeric_limits<double>::quiet_NaN();
  if (lower - slack <= claimed && claimed <= upper + slack) return claimed;
  return std::isnan(claimed) ? 0.5 * (lower + upper) : std::clamp(claimed, lower, upper);
}

}  // namespace conddp
