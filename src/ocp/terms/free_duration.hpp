#pragma once

#include <compare>

namespace conddp {

/// Free duration of a phase: a held number of the state, s. Steps are as given where it has its
/// written value, and proportional to it elsewhere; so are costs that grow with it.
struct FreeDuration {
  int choice;      ///< index among the held numbers
  double written;  ///< s

  auto operator<=>(const FreeDuration&) const = default;
};

}  // namespace conddp
