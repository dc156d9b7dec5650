#pragma once

#include <chrono>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// Several consecutive solves that appear to the caller as one: their iterations, logs and times
/// are joined, and limits cover all of them together.
class JoinedSolves {
 public:
  /// Adapts a row of a solve's log to the joined log.
  using Mark = std::function<void(IterationRecord&)>;

  /// `options` must outlive this object.
  explicit JoinedSolves(const SolverOptions& options) : options_(options) {}

  int iterations_left() const;
  /// s since the first solve began.
  double seconds() const;
  /// Options of the next solve: the remaining limits, and a callback that reports rows of the
  /// joined log. Valid until that solve is added.
  SolverOptions next(Mark mark = {});
  /// Adds the results of the solve that used the options of next().
  void add(const SolveResult& result);
  /// Returns `last` as the joint answer.
  SolveResult answer(SolveResult last);

 private:
  IterationRecord placed(IterationRecord row) const;

  const SolverOptions& options_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  Mark mark_;
  double solve_began_ = 0;
  bool interrupted_ = false;
  int solves_ = 0, iterations_ = 0;
  SolveTimes times_;
  std::string start_;
  std::vector<IterationRecord> log_;
};

/// First penalty of a solve that continues from where another one ended: the geometric mean of the
/// overall first penalty and the largest penalty needed. The first penalty alone would release
/// constraints that the multipliers hold, or that have been restored.
double next_first_penalty(const SolverOptions& options, const SolveResult& last);

}  // namespace conddp
