#pragma once

#include <cstdint>
#include <vector>

namespace conddp {

/// The most coordinates that a Sobol sequence has here.
inline constexpr int kSobolDimensions = 16;

/// A Sobol sequence in the unit cube, [0, 1) in every coordinate: of its first 2^k points every
/// coordinate has one in each of 2^k equal intervals. The seed shifts all points by the exclusive
/// or of their binary digits, which keeps that property; 0 leaves them as they are, beginning with
/// the origin. Direction numbers: Joe and Kuo (2008), new-joe-kuo-6.21201.
class SobolSequence {
 public:
  SobolSequence(int dimensions, std::uint64_t seed);
  /// The next point.
  std::vector<double> next();

 private:
  std::vector<std::vector<std::uint32_t>> directions_;  ///< a coordinate, then a digit
  std::vector<std::uint32_t> point_;
  std::uint32_t count_ = 0;
};

}  // namespace conddp
