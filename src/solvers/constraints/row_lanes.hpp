#pragma once

#include <type_traits>

#include "spatial/lane_memory.hpp"

namespace conddp {

/// For formulas of bound rows that are templates on the scalar. Most of a problem's many rows are
/// inactive, and a lane of them is skipped at once.

/// Loads the numbers from here on that S holds, one or a lane; store_rows() writes them.
template <class S>
S load_rows(const double* from) {
  if constexpr (std::is_same_v<S, Lane>)
    return load_lane(from);
  else
    return *from;
}
inline void store_rows(double* to, double x) { *to = x; }
inline void store_rows(double* to, Lane x) { store_lane(to, x); }

/// Calls f(S(), r) for the rows r of a constraint, with S = Lane for whole lanes of rows and then S
/// = double.
template <class F>
void for_each_lane(int rows, F f) {
  int r = 0;
  for (; r + kLaneWidth <= rows; r += kLaneWidth) f(Lane(0.0), r);
  for (; r < rows; ++r) f(0.0, r);
}

/// True if lower < value < upper in all rows.
inline bool all_strictly_inside(const double* values, const double* lower, const double* upper,
                                int rows) {
  int r = 0;
  for (; r + kLaneWidth <= rows; r += kLaneWidth) {
    const Lane s = load_lane(values + r);
    if (any(!((load_lane(lower + r) < s) & (s < load_lane(upper + r))))) return false;
  }
  for (; r < rows; ++r)
    if (!(lower[r] < values[r] && values[r] < upper[r])) return false;
  return true;
}

}  // namespace conddp
