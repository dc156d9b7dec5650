#pragma once

namespace conddp {

/// Residuals are shared by threads and own no mutable memory. Temporary numbers of a pass are on
/// the stack, at most this many.
inline constexpr int kMostStackNumbers = 4096;

/// Calls run(numbers) with at least `count` uninitialized numbers.
template <class S, class Run>
void with_stack_numbers(int count, Run&& run) {
  constexpr int kFew = 128, kMany = 1024;
  if (count <= kFew) {
    S numbers[kFew];
    run(numbers);
  } else if (count <= kMany) {
    S numbers[kMany];
    run(numbers);
  } else {
    S numbers[kMostStackNumbers];
    run(numbers);
  }
}

}  // namespace conddp
