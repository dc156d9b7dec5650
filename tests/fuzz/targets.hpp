#pragma once

#include <span>
#include <string_view>

namespace conddp {

/// One parser's entry: takes any bytes, must return, and aborts where a promise about the answer
/// (an error has a message and a place inside the text, a good input has none) does not hold.
struct FuzzTarget {
  std::string_view name;  ///< of its folder in tests/fuzz, too
  void (*run)(std::string_view input);
};

std::span<const FuzzTarget> fuzz_targets();

}  // namespace conddp
