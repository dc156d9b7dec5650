#pragma once

#include <compare>

namespace conddp {

/// Free duration of a phase: a held number of the state, s. It scales the time steps of the phase,
/// and the costs that grow with it, by its ratio to the written duration.
struct FreeDuration {
  int choice;      ///< index among the held numbers
  double written;  ///< s

  auto operator<=>(const FreeDuration&) const = default;
};

}  // namespace conddp
