#pragma once

#include <chrono>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// Record of a solve: the row of the current iterate, the log, status and message. It also decides
/// whether the limits of the solve let it continue. From the second solve on, it allocates only for
/// messages that others compose.
class SolveRecord {
 public:
  /// `constrained`: the solver has multipliers, so its messages report complementarity.
  SolveRecord(const ShootingProblem& problem, const SolverOptions& options, bool constrained);

  /// Clears the solve before and starts the clock.
  void begin();
  /// Appends the row, with the time, to the log and passes it to `on_iteration`.
  void log_row();
  /// Ends the solve. Always returns false, for the caller to return in turn.
  bool end(SolveStatus status, std::string_view message);
  template <class... Values>
  bool end(SolveStatus status, fmt::format_string<Values...> format, Values&&... values) {
    result.status = status;
    result.message.clear();
    fmt::format_to(std::back_inserter(result.message), format, std::forward<Values>(values)...);
    return false;
  }
  /// False, with the status set, if time or an interruption ends the solve.
  bool budget_left();
  /// The same, but also false if the iterations are used up.
  bool may_continue();
  /// Residuals of the row, with the knots where they are attained. Valid until the next call.
  std::string_view residual_text();
  /// Copies the residuals of the log row into the result.
  void write_residuals();
  double elapsed() const;
  /// Resizes the result's control gradients to the controls of the knots, and returns them.
  std::vector<Eigen::VectorXd>& control_gradient();
  /// Result with the number of iterations and the time. Valid until begin().
  SolveResult& finished();

  IterationRecord row;
  SolveResult result;
  /// True if the last row of the log does not describe the current iterate.
  bool log_is_stale = false;

 private:
  const ShootingProblem& problem_;
  const SolverOptions& options_;
  bool constrained_;
  SolveResult blank_;                      ///< without gains, which are large
  std::vector<Eigen::VectorXd> gradient_;  ///< memory of control_gradient() between two solves
  fmt::memory_buffer text_;
  std::chrono::steady_clock::time_point began_;
};

}  // namespace conddp
