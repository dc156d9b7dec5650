#pragma once

#include <limits>
#include <string>

namespace conddp {

/// A statement of an answer about itself, and what was found instead.
struct Check {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string name;  ///< "gap", "cost effort", "status", ...
  bool holds = true;
  double claimed = kNone;    ///< not a number where there is no claim in figures
  double found = kNone;      ///< the same quantity, computed anew
  double tolerance = kNone;  ///< by which the two may differ
  std::string place;         ///< "knot 12 (phase 'swing'), v/elbow", empty where it has none
  std::string message;       ///< what does not hold, empty where the figures say it
};

/// Names of checks of an answer that say that it is optimal.
inline constexpr const char* kStatusCheck = "status";
inline constexpr const char* kFeedforwardCheck = "feedforward";

}  // namespace conddp
