#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/certificate/answer_check.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Measurements of a solver on a problem.
struct BenchmarkRun {
  std::string solver;
  std::string status;   ///< status of the solve, or "refused"
  std::string message;  ///< reason of the status
  int iterations = 0;
  /// Backward passes, or equation systems in methods without passes: at least one per iteration.
  int sweeps = 0;
  AnswerCheck check;          ///< result of check_answer
  Residuals claimed;          ///< residuals that the solver reports
  bool solved = false;        ///< converged, and the check agrees
  SolveTimes median;          ///< medians over the timed solves, part by part, s
  std::vector<double> times;  ///< total of each timed solve, s; empty if refused

  /// (largest − smallest) / median of the times.
  double spread() const;
  /// False if a solver reports convergence that the check does not confirm.
  bool kept_word() const { return solved || status != to_string(SolveStatus::converged); }
};

/// Repetition of a timed solve.
struct Repetition {
  int count = 0;  ///< solves after a warm-up; 0: the warm-up itself is timed
  /// A solve that took longer is not repeated, s.
  double longest_s = std::numeric_limits<double>::infinity();
};

/// The check confirms a reported residual up to this multiple of its tolerance. Stationarity along
/// another policy is a different number.
inline constexpr double kCheckFactor = 10;

/// Solves with the first of several solvers that converges: once to warm up, then as often as
/// `repetition` says against the clock, one after the other. `name` is the solver name of the run.
/// If the warm-up hits the time limit or may not be repeated, its own time counts. If the problem
/// or an option is refused, the run has that status. `answer`, if given, receives the trajectory
/// found.
BenchmarkRun run_benchmark(const ShootingProblem& problem, const Trajectory& guess,
                           std::string_view name, SolverList solvers, const SolverOptions& options,
                           const Repetition& repetition, Trajectory* answer = nullptr);
/// The same for the solver of the given name, including `auto`.
BenchmarkRun run_benchmark(const ShootingProblem& problem, const Trajectory& guess,
                           std::string_view solver, const SolverOptions& options,
                           const Repetition& repetition, Trajectory* answer = nullptr);

/// Median of some numbers (mean of the middle two for an even count); NaN if empty.
double median(std::vector<double> values);

}  // namespace conddp
