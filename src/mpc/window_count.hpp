#pragma once

#include "mpc/mpc.hpp"

namespace conddp {

/// The windows for which a loop has solvers.
struct WindowCount {
  int structures = 0;  ///< each of which has one of its own, at least
  int knots = 0;       ///< of the longest of them
};

/// Counts the structures of a loop's windows, without the solvers that Mpc has for them. Windows
/// that re-timing makes are not among them, nor are those that differ in nothing but constraints
/// that are switched off.
WindowCount count_windows(std::shared_ptr<const ShootingProblem> problem, const MpcOptions& options,
                          double duration);

}  // namespace conddp
