#pragma once

#include <functional>
#include <optional>

namespace conddp {

/// Bisects a range for the largest number that a loop survives, down to an interval of `width`. The
/// ends are tried first. Exact if it survives all numbers below a threshold and none above it.
/// Empty if it does not survive `low`.
std::optional<double> largest_survived(double low, double high, double width,
                                       const std::function<bool(double)>& survives);

}  // namespace conddp
