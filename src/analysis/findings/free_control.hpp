#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A control that a problem leaves free.
struct FreeControl {
  std::string name;
  std::string phase;
  int knot = 0;  ///< first knot with the free control
};

/// First control with neither a bound, nor a cost that counts, nor a constraint at some knot that
/// takes time; otherwise nullopt.
std::optional<FreeControl> free_control(const ShootingProblem& problem);

}  // namespace conddp
