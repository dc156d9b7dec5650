#pragma once

namespace conddp {

/// Sanitizers, under which arithmetic takes up to a hundred times as long, look for errors that do
/// not depend on sizes: tests take small ones there.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kSmallSizes = true;
#else
inline constexpr bool kSmallSizes = false;
#endif

/// From one direction to the next in which a test compares derivatives.
inline constexpr int kDirectionStride = kSmallSizes ? 5 : 1;

}  // namespace conddp
