#pragma once

#include <cstdint>

#include "spatial/lane_transpose.hpp"

#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace conddp {

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
