#include "batch/plan/spread.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace conddp {
namespace {

/// Golden section of a circle: steps of this size leave gaps of nearly equal size, for any number
/// of steps.
constexpr double kGoldenShare = 0.6180339887498949;

/// The step nearest to the golden section that visits all numbers below `count`.
std::size_t coprime_step(std::size_t count) {
  const auto nearest =
      static_cast<std::size_t>(std::llround(kGoldenShare * static_cast<double>(count)));
  for (std::size_t away = 0;; ++away) {
    if (std::gcd(nearest + away, count) == 1) return nearest + away;
    if (away < nearest && std::gcd(nearest - away, count) == 1) return nearest - away;
  }
}

}  // namespace

std::vector<std::size_t> spread_over(std::size_t count, std::size_t wanted) {
  const std::size_t step = coprime_step(count);
  std::vector<std::size_t> numbers(std::min(count, wanted));
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = i * step % count;
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace conddp
