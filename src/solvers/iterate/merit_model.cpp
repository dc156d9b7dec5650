#include "solvers/iterate/merit_model.hpp"

#include <cmath>

namespace conddp {
namespace {

/// Armijo's rule sees a change of the merit from this multiple of its estimated rounding on.
constexpr double kVisible = 10;

}  // namespace

bool MeritModel::hidden(double change) const { return std::abs(change) <= kVisible * rounding; }

bool MeritModel::passes(double expected, double actual, bool first) const {
  if (expected > 0 && actual >= kArmijo * expected) return true;
  return first && hidden(expected) && hidden(actual);
}

}  // namespace conddp
