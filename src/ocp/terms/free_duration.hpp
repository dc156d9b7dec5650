#pragma once

#include <optional>

namespace conddp {

/// Where the duration of a phase is free: a number of the held memory is that duration, s, and the
/// phase's steps are as given where it is the written one.
struct FreeDuration {
  int choice;               ///< which number
  double written;           ///< s
  bool scales_cost = true;  ///< running costs are rates
};

/// Which free durations a cost is multiplied by besides the knot's cost scale, each as a share of
/// the written one.
struct CostGrowth {
  bool is_moment = false;                  ///< not that of its knot: it is of an instant
  std::optional<FreeDuration> other = {};  ///< that of another phase
};

}  // namespace conddp
