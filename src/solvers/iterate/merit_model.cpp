#include "solvers/iterate/merit_model.hpp"

#include <cmath>

namespace conddp {
namespace {

/// How many times its estimated rounding a merit has to change for Armijo's rule to see it.
constexpr double kVisible = 10;

}  // namespace

bool MeritModel::hidden(double change) const { return std::abs(change) <= kVisible * rounding; }

bool MeritModel::passes(double expected, double actual, double armijo, bool first) const {
  if (expected > 0 && actual >= armijo * expected) return true;
  return first && hidden(expected) && hidden(actual);
}

}  // namespace conddp
