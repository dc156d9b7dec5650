#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/common/status.hpp"

namespace conddp {

/// A solve along a homotopy.
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
  int start = 0;  ///< 0 for the guess itself, else the number of its random perturbation
  SolveStatus status = SolveStatus::diverged;
  int iterations = 0;
  double cost = std::numeric_limits<double>::quiet_NaN();
  double time_s = 0;
  std::string objection;  ///< to its answer; empty if none was found or sought
  bool jumps = false;     ///< the motion jumps through a region that it should go around
  bool chosen = false;    ///< its answer is the overall answer
};

/// A local optimum, and the starts that ended there.
struct Basin {
  double cost = 0;  ///< of the first of these starts
  int starts = 0;   ///< number of these starts
  int first = 0;    ///< first of these starts; 0 is the guess itself
};

/// Outcome of the starts of a solve with restarts.
struct RestartRecord {
  int starts = 0;             ///< starts made: fewer than requested if time ran out
  int converged = 0;          ///< starts that converged
  int answer = 0;             ///< start whose answer is returned
  std::vector<Basin> basins;  ///< basins of the converged starts, the cheapest first
};

}  // namespace conddp
