#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A control that a problem leaves free.
struct FreeControl {
  std::string name;
  std::string phase;
  int knot = 0;  ///< the first where it is
};

/// The first control that has neither a bound, nor a cost that counts, nor a constraint at some
/// knot that takes time; nothing where there is none.
std::optional<FreeControl> free_control(const ShootingProblem& problem);

}  // namespace conddp
