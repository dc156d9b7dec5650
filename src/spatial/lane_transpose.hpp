#pragma once

#include <utility>

#include "spatial/lane.hpp"

namespace conddp {

namespace detail {
/// Selects lanes of two vectors by index: first the lanes of a, then those of b.
template <int... kIndex>
inline Lane pick(Lane a, Lane b) {
#if defined(__clang__)
  return Lane(__builtin_shufflevector(a.v, b.v, kIndex...));
#else
  return Lane(__builtin_shuffle(a.v, b.v, LaneMask::Vector{kIndex...}));
#endif
}

/// Exchanges the off-diagonal quadrants in every square of 2 kHalf rows and lanes, as far as needed
/// for the first kRows rows of the result.
template <int kRows, int kHalf, int... kIndex>
inline void exchange_quadrants(Lane (&x)[kLaneWidth], std::integer_sequence<int, kIndex...> lanes) {
  constexpr int kNeeded = (kRows + kHalf - 1) / kHalf * kHalf;
#pragma GCC unroll 8
  for (int r = 0; r < kNeeded; ++r) {
    if ((r & kHalf) != 0) continue;
    const Lane a = x[r], b = x[r + kHalf];
    x[r] = pick<((kIndex & kHalf) != 0 ? kLaneWidth + kIndex - kHalf : kIndex)...>(a, b);
    if (r + kHalf >= kNeeded) continue;
    x[r + kHalf] = pick<((kIndex & kHalf) != 0 ? kLaneWidth + kIndex : kIndex + kHalf)...>(a, b);
  }
  if constexpr (kHalf > 1) exchange_quadrants<kRows, kHalf / 2>(x, lanes);
}
}  // namespace detail

/// Transposes: lane i of vector j becomes lane j of vector i, for i < kRows. The other vectors are
/// left undefined.
template <int kRows = kLaneWidth>
inline void transpose_lanes(Lane (&x)[kLaneWidth]) {
  detail::exchange_quadrants<kRows, kLaneWidth / 2>(x,
                                                    std::make_integer_sequence<int, kLaneWidth>());
}

/// Load and store kLaneWidth numbers, unaligned.
inline Lane load_lane(const double* from) {
  Lane x;
  __builtin_memcpy(&x, from, sizeof x);
  return x;
}
inline void store_lane(double* to, Lane x) { __builtin_memcpy(to, &x, sizeof x); }

}  // namespace conddp
