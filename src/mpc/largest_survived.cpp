#include "mpc/largest_survived.hpp"

namespace conddp {

std::optional<double> largest_survived(double low, double high, double width,
                                       const std::function<bool(double)>& survives) {
  if (!survives(low)) return std::nullopt;
  if (survives(high)) return high;
  while (high - low > width) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;  // no number lies in between
    (survives(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace conddp
