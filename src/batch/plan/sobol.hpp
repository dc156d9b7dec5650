#pragma once

#include <cstdint>
#include <vector>

namespace conddp {

/// Maximum number of coordinates of a Sobol sequence.
inline constexpr int kSobolDimensions = 16;

/// A Sobol sequence in the unit cube, [0, 1) in every coordinate. Each of 2^k equal intervals of a
/// coordinate contains exactly one of the first 2^k points. The seed shifts all points by an
/// exclusive or of their binary digits, which preserves that property. A seed of 0 does not shift
/// the points, which then begin with the origin. Direction numbers: Joe and Kuo (2008),
/// new-joe-kuo-6.21201.
class SobolSequence {
 public:
  SobolSequence(int dimensions, std::uint64_t seed);
  /// The next point.
  std::vector<double> next();

 private:
  std::vector<std::vector<std::uint32_t>> directions_;  ///< by coordinate, then by digit
  std::vector<std::uint32_t> point_;
  std::uint32_t count_ = 0;
};

}  // namespace conddp
