#pragma once

#include "solvers/common/options.hpp"

namespace conddp {

/// Whether all residuals but the stationarity are under tolerance, of a row of the log
/// (IterationRecord) or an answer (Residuals).
template <class Residuals>
bool is_feasible(const Residuals& at, const SolverOptions::Tolerances& tolerances) {
  return at.gap <= tolerances.gap && at.constraint <= tolerances.constraint &&
         at.complementarity <= tolerances.complementarity;
}

}  // namespace conddp
