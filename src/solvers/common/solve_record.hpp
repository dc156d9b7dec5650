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

/// What a solve says of itself: the row of the present iterate, the log, status and message; and
/// whether its limits let it go on. From the second solve on it allocates nothing but messages that
/// others compose.
class SolveRecord {
 public:
  /// `constrained`: whether the solver knows multipliers, so that its messages speak of
  /// complementarity.
  SolveRecord(const ShootingProblem& problem, const SolverOptions& options, bool constrained);

  /// Forgets the solve before; the clock starts.
  void begin();
  /// Appends the row, with the time, to the log and shows it to who watches.
  void log_row();
  /// Ends the solve. What is returned is false, for the step in which it ends to return.
  bool end(SolveStatus status, std::string_view message);
  template <class... Values>
  bool end(SolveStatus status, fmt::format_string<Values...> format, Values&&... values) {
    result.status = status;
    result.message.clear();
    fmt::format_to(std::back_inserter(result.message), format, std::forward<Values>(values)...);
    return false;
  }
  /// False, with the status, where time or a signal ends the solve.
  bool budget_left();
  /// The same, and where the iterations are used up.
  bool may_continue();
  /// The residuals of the row, with the knots where they are attained; until the next call.
  std::string_view residual_text();
  double elapsed() const;
  /// Gives the result a gradient for every knot, of the sizes of their controls, and returns it.
  std::vector<Eigen::VectorXd>& control_gradient();
  /// The result with the number of iterations and the time; it stays until begin().
  SolveResult& finished();

  IterationRecord row;
  SolveResult result;
  /// Whether the last row of the log is not that of the iterate that stands.
  bool log_is_stale = false;

 private:
  const ShootingProblem& problem_;
  const SolverOptions& options_;
  bool constrained_;
  SolveResult blank_;                      ///< without gains, which are many numbers
  std::vector<Eigen::VectorXd> gradient_;  ///< memory of control_gradient() between two solves
  fmt::memory_buffer text_;
  std::chrono::steady_clock::time_point began_;
};

}  // namespace conddp
