#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/common/status.hpp"

namespace conddp {

/// A solve on the way of a homotopy.
struct HomotopyStep {
  double share = 0;  ///< of the way: 0 at its start, 1 at the problem itself
  SolveStatus status = SolveStatus::diverged;
  int iterations = 0;
  double cost = std::numeric_limits<double>::quiet_NaN();
  double time_s = 0;
};

/// A solve by one of several solvers, or from one of several guesses.
struct Attempt {
  std::string_view solver;
  int start = 0;  ///< 0: the guess itself, else the number of its random perturbation
  SolveStatus status = SolveStatus::diverged;
  int iterations = 0;
  double cost = std::numeric_limits<double>::quiet_NaN();
  double time_s = 0;
  std::string objection;  ///< to its answer; empty: none, or nobody asked
  bool jumps = false;     ///< through what the motion should go around
  bool chosen = false;    ///< its answer is that of all
};

/// A local optimum, and the starts that ended there.
struct Basin {
  double cost = 0;  ///< of the first of these starts
  int starts = 0;   ///< how many
  int first = 0;    ///< the first one; 0 is the guess itself
};

/// What came of the starts of a solve with restarts.
struct RestartRecord {
  int starts = 0;             ///< that were made: fewer than asked for where time ran out
  int converged = 0;          ///< of these
  int answer = 0;             ///< the start whose answer counts
  std::vector<Basin> basins;  ///< of the converged ones, the cheapest first
};

}  // namespace conddp
