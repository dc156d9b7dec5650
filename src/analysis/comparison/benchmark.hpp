#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/certificate/answer_check.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// A solver on a problem, measured.
struct BenchmarkRun {
  std::string solver;
  std::string status;   ///< how the solve ended, or "refused"
  std::string message;  ///< why
  int iterations = 0;
  /// Backward passes, or systems of equations where there are no passes: at least one an iteration.
  int sweeps = 0;
  AnswerCheck check;          ///< found by check_answer
  Residuals claimed;          ///< what the solver said
  bool solved = false;        ///< converged, and the check agrees
  SolveTimes median;          ///< of the timed solves, each part by itself, s
  std::vector<double> times;  ///< of each timed solve, s; empty where it was refused

  /// (largest − smallest) / median of the times.
  double spread() const;
  /// Not so where a solver called an answer converged that the check does not confirm.
  bool kept_word() const { return solved || status != to_string(SolveStatus::converged); }
};

/// How often a solve is timed.
struct Repetition {
  int count = 0;  ///< solves after one to warm up; 0: that one alone, timed
  /// A solve that took longer is not repeated either, s.
  double longest_s = std::numeric_limits<double>::infinity();
};

/// How far over the tolerance the check of an answer may find a residual before the solver's word
/// is doubted: stationarity along another policy is another number.
inline constexpr double kCheckFactor = 10;

/// Solves by the first of some solvers that converges, once to warm up, then as often as is asked
/// for against the clock, one after the other; `name` is what the run calls them. A solve that
/// ended for want of time, or is not to be repeated, counts itself. A refusal, of the problem or of
/// an option, is a run with that status. `answer`, if wanted, receives the trajectory that was
/// found.
BenchmarkRun run_benchmark(const ShootingProblem& problem, const Trajectory& guess,
                           std::string_view name, SolverList solvers, const SolverOptions& options,
                           const Repetition& repetition, Trajectory* answer = nullptr);
/// The same by the solver of a name, `auto` included.
BenchmarkRun run_benchmark(const ShootingProblem& problem, const Trajectory& guess,
                           std::string_view solver, const SolverOptions& options,
                           const Repetition& repetition, Trajectory* answer = nullptr);

/// The middle of some numbers (of two, their mean); not-a-number of none.
double median(std::vector<double> values);

}  // namespace conddp
