#pragma once

#include <limits>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A claim of an answer about itself, and the value found instead.
struct Check {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string name;  ///< "gap", "cost effort", "status", ...
  bool holds = true;
  double claimed = kNone;    ///< NaN if the claim is not a number
  double found = kNone;      ///< the same quantity, recomputed
  double tolerance = kNone;  ///< allowed difference
  std::string place;         ///< "knot 12 (phase 'swing'), v/elbow", or empty
  std::string message;       ///< reason of a failure; empty if the figures show it
};

/// Names of the checks for the optimality of an answer.
inline constexpr const char* kStatusCheck = "status";
inline constexpr const char* kFeedforwardCheck = "feedforward";

/// "knot 12 (phase 'swing'), v/elbow"; the last part is omitted if `quantity` is empty.
std::string place_text(const ShootingProblem& problem, int knot, const std::string& quantity);

/// Name of a control at its knot. The controls of a free initial state are its components. Empty if
/// the control does not exist or is not named.
std::string control_name(const ShootingProblem& problem, int knot, int entry);

}  // namespace conddp
