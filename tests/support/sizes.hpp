#pragma once

namespace conddp {

/// Under sanitizers, arithmetic takes up to a hundred times longer, and their errors do not depend
/// on sizes: tests use small sizes there.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kSmallSizes = true;
#else
inline constexpr bool kSmallSizes = false;
#endif

/// Stride between the directions along which a test compares derivatives.
inline constexpr int kDirectionStride = kSmallSizes ? 5 : 1;

}  // namespace conddp
