#pragma once

#include <chrono>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// Several solves, one after the other, that are one to whoever asked for it: their iterations, log
/// and times follow each other, and limits are those of all together.
class JoinedSolves {
 public:
  /// Changes a row of the log into one of the whole.
  using Mark = std::function<void(IterationRecord&)>;

  /// `options` live longer.
  explicit JoinedSolves(const SolverOptions& options) : options_(options) {}

  int iterations_left() const;
  /// s, since the first solve began.
  double seconds() const;
  /// The options of the next solve: what is left of the limits, and rows that are shown as rows of
  /// the whole. Valid until that solve is added.
  SolverOptions next(Mark mark = {});
  /// Takes what the solve that was made with the options of next() did.
  void add(const SolveResult& result);
  /// `last` as the answer of all.
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

/// The first penalty of a solve that goes on from where another one ended: the geometric mean of
/// the first penalty of all and the largest one that was needed. The first one would let go of
/// constraints that the multipliers hold, or that have been restored.
double next_first_penalty(const SolverOptions& options, const SolveResult& last);

}  // namespace conddp
