#pragma once

#include <span>

namespace conddp {

/// Between which numbers a derivative lies by differences of values; not finite where there are
/// none.
struct SlopeInterval {
  double lower, upper;
};

/// The interval of the slopes of two secants.
SlopeInterval between_slopes(double a, double b);

/// The interval at the edge of a domain, from the slopes of a secant of one step and of one of a
/// quarter of it: it reaches from the longer one's beyond the shorter one's, as far as derivatives
/// go that change with the square root of the distance or more smoothly.
SlopeInterval at_edge(double slope, double slope_of_quarter);

/// The step of differences that balances their error and rounding where functions change as slowly
/// as a coordinate is large.
double difference_step(double coordinate);

/// Whether the slope of a shorter step confirms that of a longer one: they agree but for a small
/// part and for the rounding of values of this size over the shorter step.
bool confirms_slope(double of_shorter, double of_longer, double value_per_step);

/// The interval that one step of differences gives.
struct MeasuredSlope {
  SlopeInterval interval;
  double noise;  ///< how far rounding may have moved its ends
};

/// Of measurements with ever smaller steps, the one that is known best: that with the least sum of
/// its width, its noise, and what the next step changes. A step that passes over periods or steep
/// places of a function gives a narrow interval that the next one denies.
const MeasuredSlope& best_measured(std::span<const MeasuredSlope> steps);

/// The derivative as it is claimed where it lies in the interval up to `slack`; otherwise the
/// number of the interval that is nearest to it; NaN where the interval is not finite.
double confirmed_slope(double claimed, const SlopeInterval& interval, double slack);

}  // namespace conddp
