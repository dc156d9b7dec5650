#pragma once

#include <cstdint>
#include <utility>

#include "spatial/lane.hpp"

#if defined(__AVX__)
#include <immintrin.h>
#endif

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

/// Load and store the first `count` < kLaneWidth numbers; load_part sets the other lanes to zero.
inline Lane load_part(const double* from, int count) {
#if defined(__AVX512F__)
  return Lane(Lane::Vector(_mm512_maskz_loadu_pd(static_cast<__mmask8>((1 << count) - 1), from)));
#elif defined(__AVX__)
  static constexpr std::int64_t kMasks[] = {-1, -1, -1, -1, 0, 0, 0, 0};
  const __m256i mask = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(kMasks + 4 - count));
  return Lane(Lane::Vector(_mm256_maskload_pd(from, mask)));
#else
  Lane x(0.0);
  for (int i = 0; i < count; ++i) x.set(i, from[i]);
  return x;
#endif
}
inline void store_part(double* to, Lane x, int count) {
#if defined(__AVX512F__)
  _mm512_mask_storeu_pd(to, static_cast<__mmask8>((1 << count) - 1), __m512d(x.v));
#else
  for (int i = 0; i < count; ++i) to[i] = x[i];
#endif
}

/// Load and store min(`left`, kLaneWidth) numbers.
inline Lane load_some(const double* from, int left) {
  return left >= kLaneWidth ? load_lane(from) : load_part(from, left);
}
inline void store_some(double* to, Lane x, int left) {
  left >= kLaneWidth ? store_lane(to, x) : store_part(to, x, left);
}

}  // namespace conddp
