#pragma once

#include "solvers/common/options.hpp"

namespace conddp {

/// True if all residuals except stationarity are within tolerance, for a row of the log
/// (IterationRecord) or an answer (Residuals).
template <class Residuals>
bool is_feasible(const Residuals& at, const SolverOptions::Tolerances& tolerances) {
  return at.gap <= tolerances.gap && at.constraint <= tolerances.constraint &&
         at.complementarity <= tolerances.complementarity;
}

}  // namespace conddp
