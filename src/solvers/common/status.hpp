#pragma once

#include <string_view>

namespace conddp {

/// Outcome of a solve. Negative values are failures; they have outputs, too.
enum class SolveStatus {
  /// Stationarity, dynamics gap and constraint violation are all within tolerance at once.
  converged = 0,
  /// The allowed number of iterations was used up first.
  max_iterations = -1,
  /// No step length lowers the merit under any regularization, or rounding hides the progress.
  line_search_failed = -2,
  /// A stage Hessian stays indefinite up to the largest regularization.
  regularization_limit = -3,
  /// A state, cost or derivative of an iterate is not finite.
  diverged = -4,
  /// No small change of the trajectory lowers the violation of the constraints (ViolationSlope).
  infeasible = -5,
  /// The allowed wall-clock time was used up first.
  time_limit = -6,
  /// The caller asked to stop.
  interrupted = -7,
  /// Feasible, and the cost falls no faster than `tolerances.cost_decrease`, while stationarity is
  /// above its tolerance.
  cost_settled = 1,
};

/// True if a solve ended within its tolerances: converged, or cost_settled.
bool is_success(SolveStatus status);

/// Name in outputs: "converged", "max_iterations", ...
std::string_view to_string(SolveStatus status);

}  // namespace conddp
