#pragma once

#include <chrono>
#include <string>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// What a solve says of itself: the row of the present iterate, the log, status and message; and
/// whether its limits let it go on.
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
  bool end(SolveStatus status, std::string message);
  /// False, with the status, where time or a signal ends the solve.
  bool budget_left();
  /// The same, and where the iterations are used up.
  bool may_continue();
  /// The residuals of the row, with the knots where they are attained.
  std::string residual_text() const;
  double elapsed() const;
  SolveResult take();

  IterationRecord row;
  SolveResult result;
  /// Whether the last row of the log is not that of the iterate that stands.
  bool log_is_stale = false;

 private:
  const ShootingProblem& problem_;
  const SolverOptions& options_;
  bool constrained_;
  std::chrono::steady_clock::time_point began_;
};

}  // namespace conddp
