#pragma once

namespace conddp {

/// Residuals are shared by threads and own no memory that changes: numbers that a pass needs
/// meanwhile are on the stack, at most so many.
inline constexpr int kMostStackNumbers = 4096;

/// Calls run(numbers) with at least `count` numbers, not initialised.
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
