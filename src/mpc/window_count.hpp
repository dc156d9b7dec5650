#pragma once

#include "mpc/mpc.hpp"

namespace conddp {

/// Windows that a loop needs solvers for.
struct WindowCount {
  int structures = 0;  ///< each with at least one solver
  int knots = 0;       ///< of the longest window
};

/// Counts the structures of a loop's windows, without building the solvers of Mpc. Windows made by
/// re-timing are not counted. Windows that differ only in inactive constraints count once.
WindowCount count_windows(std::shared_ptr<const ShootingProblem> problem, const MpcOptions& options,
                          double duration);

}  // namespace conddp
