#pragma once

#include <string_view>

namespace conddp {

/// How a solve ended. Negative values are failures, with outputs all the same.
enum class SolveStatus {
  /// Stationarity, dynamics gap and constraint violation are all under tolerance at once.
  converged = 0,
  /// The allowed number of iterations was used up first.
  max_iterations = -1,
  /// No step length lowers the merit, whatever the regularisation, or rounding hides the progress.
  line_search_failed = -2,
  /// A stage Hessian stays indefinite up to the largest regularisation.
  regularization_limit = -3,
  /// A state, cost or derivative of an iterate is not finite.
  diverged = -4,
  /// No small change of the trajectory lowers the violation of the constraints (ViolationSlope).
  infeasible = -5,
  /// The allowed wall-clock time was used up first.
  time_limit = -6,
  /// The caller asked to stop.
  interrupted = -7,
  /// Feasible, and the cost falls no faster than `tolerances.cost_decrease`, while the stationarity
  /// is above its tolerance.
  cost_settled = 1,
};

/// Whether a solve ended where its tolerances let it end: converged, or cost_settled.
bool is_success(SolveStatus status);

/// The name as it stands in outputs: "converged", "max_iterations", ...
std::string_view to_string(SolveStatus status);

}  // namespace conddp
