#pragma once

#include <string>
#include <vector>

#include "analysis/answer_check.hpp"
#include "solvers/registry.hpp"

namespace conddp {

/// A solver on a problem, measured.
struct BenchmarkRun {
  std::string solver;
  std::string status;   ///< how the solve ended, or "refused"
  std::string message;  ///< why
  int iterations = 0;
  AnswerCheck check;          ///< found by check_answer
  Residuals claimed;          ///< what the solver said
  bool solved = false;        ///< converged, and the check agrees
  SolveTimes median;          ///< of the timed solves, each part by itself, s
  std::vector<double> times;  ///< of each timed solve, s; empty where it was refused

  /// (largest − smallest) / median of the times.
  double spread() const;
};

/// How far over the tolerance the check of an answer may find a residual before the solver's word
/// is doubted: stationarity along another policy is another number.
inline constexpr double kCheckFactor = 10;

/// Solves once to warm up, then `repeat` times against the clock, one after the other. A solve that
/// ended for want of time, and every one if `repeat` is 0, is not repeated: its own time counts.
/// A refusal, of the problem or of an option, is a run with that status. `answer`, if wanted,
/// receives the trajectory that was found.
BenchmarkRun run_benchmark(const ShootingProblem& problem, const Trajectory& guess,
                           const SolverInfo& solver, const SolverOptions& options, int repeat,
                           Trajectory* answer = nullptr);

/// The middle of some numbers (of two, their mean); not-a-number of none.
double median(std::vector<double> values);

}  // namespace conddp
