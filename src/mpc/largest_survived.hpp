#pragma once

#include <functional>
#include <optional>

namespace conddp {

/// Looks by bisection for the largest number of a range that is survived: the ends first, then the
/// middle of what is open, until that is `width`. Exact where all numbers below one are survived
/// and none above. Nothing where `low` is not survived.
std::optional<double> largest_survived(double low, double high, double width,
                                       const std::function<bool(double)>& survives);

}  // namespace conddp
