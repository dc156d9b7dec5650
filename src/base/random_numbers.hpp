#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace conddp {

/// Uniformly distributed numbers in [0, 1) with 53 bits. A seed gives the same sequence with every
/// standard library.
class UniformNumbers {
 public:
  explicit UniformNumbers(std::uint64_t seed) : engine_(seed) {}
  double next() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 engine_;
};

/// Normally distributed numbers (Box-Muller). A seed gives the same sequence with every standard
/// library.
class NormalNumbers {
 public:
  explicit NormalNumbers(std::uint64_t seed) : uniform_(seed) {}
  double next() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform_.next()));
    return radius * std::cos(2 * std::numbers::pi * uniform_.next());
  }

 private:
  UniformNumbers uniform_;
};

}  // namespace conddp
