#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>

namespace conddp {

/// Relative margin beyond which two values count as different; it is visible in at most three
/// printed digits.
inline constexpr double kTie = 1e-3;

/// True if a candidate replaces the worst value so far. The first of nearly equal values stays, so
/// that their order decides and not a processor's rounding.
inline bool exceeds(double candidate, double worst) {
  return candidate - worst > kTie * std::min(std::abs(candidate), std::abs(worst));
}

/// The index of the worst of several values, according to exceeds().
template <class Values>
int worst_of(const Values& values) {
  int worst = 0;
  for (int i = 1; i < static_cast<int>(values.size()); ++i)
    if (exceeds(values[i], values[worst])) worst = i;
  return worst;
}

/// Sorts by exceeds(): the worst value first, then the worst of the rest.
template <class Iterator, class Value>
void sort_worst_first(Iterator first, Iterator last, Value value_of) {
  for (; first != last; ++first) {
    Iterator worst = first;
    for (Iterator i = first; i != last; ++i)
      if (exceeds(value_of(*i), value_of(*worst))) worst = i;
    std::rotate(first, worst, std::next(worst));
  }
}

}  // namespace conddp
