#pragma once

#include <cstdint>
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

}  // namespace conddp
