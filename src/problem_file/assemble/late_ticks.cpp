#include "problem_file/assemble/late_ticks.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "base/random_numbers.hpp"
#include "mpc/time_line.hpp"

namespace conddp {
namespace {

void mark(const LateSpec& late, double tick, std::vector<bool>& ticks) {
  UniformNumbers numbers(late.seed);
  const double end =
      late.at.value + late.duration.value_or(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const bool drawn = numbers.next() < late.share;
    const double time = static_cast<double>(i) * tick;
    if (drawn && !is_before(time, late.at.value) && is_before(time, end)) ticks[i] = true;
  }
}

}  // namespace

std::function<bool(int tick)> late_ticks(const MpcSpec& mpc) {
  if (mpc.late.empty()) return nullptr;
  std::vector<bool> ticks(static_cast<std::size_t>(std::ceil(mpc.duration.value / mpc.tick.value)));
  for (const LateSpec& late : mpc.late) mark(late, mpc.tick.value, ticks);
  return [ticks = std::move(ticks)](int tick) {
    return static_cast<std::size_t>(tick) < ticks.size() && ticks[tick];
  };
}

}  // namespace conddp
