#pragma once

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

/// The step of differences that balances their error and rounding, for a coordinate.
double difference_step(double coordinate);

/// The derivative as it is claimed where it lies in the interval up to `slack`; otherwise the
/// number of the interval that is nearest to it; NaN where the interval is not finite.
double confirmed_slope(double claimed, const SlopeInterval& interval, double slack);

}  // namespace conddp
