#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace conddp {

/// Normal numbers by Box and Muller, so that a seed gives the same ones with every standard
/// library.
class NormalNumbers {
 public:
  explicit NormalNumbers(std::uint64_t seed) : engine_(seed) {}
  double next() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  std::mt19937_64 engine_;
};

}  // namespace conddp
