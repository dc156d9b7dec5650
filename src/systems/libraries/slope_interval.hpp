#pragma once

#include <span>

namespace conddp {

/// Bounds on a derivative from differences of values; not finite without finite values.
struct SlopeInterval {
  double lower, upper;
};

/// The interval of the slopes of two secants.
SlopeInterval between_slopes(double a, double b);

/// The interval at the edge of a domain, from the secant slopes of a step and of a quarter of it.
/// It extends from the longer secant's slope beyond the shorter one's. That covers derivatives that
/// vary with the square root of the distance or more smoothly.
SlopeInterval at_edge(double slope, double slope_of_quarter);

/// A difference step that balances truncation and rounding error for functions that vary on the
/// scale of the coordinate.
double difference_step(double coordinate);

/// True if the slope of a shorter step confirms that of a longer one. They must agree up to a small
/// fraction and the rounding of values of this size over the shorter step.
bool confirms_slope(double of_shorter, double of_longer, double value_per_step);

/// The slope interval of one difference step.
struct MeasuredSlope {
  SlopeInterval interval;
  double noise;  ///< bound on the rounding error of its ends
};

/// The most reliable of several measurements with decreasing steps. It has the least sum of its
/// width, its noise and the change at the next step. A step across periods or steep regions of a
/// function may give a narrow interval, but the next step contradicts it.
const MeasuredSlope& best_measured(std::span<const MeasuredSlope> steps);

/// The claimed derivative if it lies in the interval up to `slack`, otherwise the nearest number in
/// the interval. NaN if the interval is not finite.
double confirmed_slope(double claimed, const SlopeInterval& interval, double slack);

}  // namespace conddp
