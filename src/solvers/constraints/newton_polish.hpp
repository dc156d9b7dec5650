#pragma once

#include "solvers/common/solve_record.hpp"
#include "solvers/constraints/outer_strategy.hpp"
#include "solvers/constraints/projected_newton.hpp"
#include "solvers/iterate/iterate.hpp"

namespace conddp {

/// Ends a solve by Newton's method on the active constraints. Its steps are iterations.
class NewtonPolish {
 public:
  NewtonPolish(const ShootingProblem& problem, Evaluator& evaluator, const SolverOptions& options);

  /// Prepares a solve.
  void reset();
  /// True if an iterate is near enough to a solution for a try.
  bool due(const IterationRecord& row) const;
  /// Takes Newton steps from an iterate. If they meet the tolerances of stationarity, gap and
  /// violation, the iterate becomes Newton's, with its multipliers, but is not linearized yet.
  /// Otherwise the result is false and the iterate stays; the next try waits until it is much
  /// nearer.
  bool run(Iterate& iterate, const Feedback& feedback, OuterStrategy& outer, SolveRecord& record);
  /// The policy of the last step, which respects the active constraints.
  const Feedback& feedback() const { return newton_.feedback(); }

 private:
  void iterate_newton(SolveRecord& record);

  ProjectedNewton newton_;
  const SolverOptions& options_;
  double threshold_ = 0;  ///< violation, gap and stationarity below which a try is due
};

}  // namespace conddp
