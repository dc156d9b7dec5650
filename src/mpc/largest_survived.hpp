#pragma once

#include <functional>
#include <optional>

namespace conddp {

/// Bisects a range for the largest number that survives, down to an interval of `width`. The ends
/// are tried first. Exact if all numbers below a threshold survive and none above it does. Empty if
/// `low` does not survive.
std::optional<double> largest_survived(double low, double high, double width,
                                       const std::function<bool(double)>& survives);

}  // namespace conddp
