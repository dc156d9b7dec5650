#pragma once

#include <span>
#include <string_view>

namespace conddp {

/// Entry of one parser. It accepts any bytes, must return, and aborts if a promise about the answer
/// is broken: an error has a message and a place inside the text, a good input has no error.
struct FuzzTarget {
  std::string_view name;  ///< also of its folder in tests/fuzz
  void (*run)(std::string_view input);
};

std::span<const FuzzTarget> fuzz_targets();

}  // namespace conddp
