#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/uniform_numbers.hpp"

namespace conddp {

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
