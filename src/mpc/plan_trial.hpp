#pragma once

#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// What comes of following a plan through a window, by the window's own problem.
struct TrialFigures {
  double violation = 0;  ///< largest one of a hard constraint; infinite where the motion diverges
  double cost = 0;
};

/// Whether the violation is less by more than a tolerance or, where the two are one within it, the
/// cost is less.
bool is_better(const TrialFigures& a, const TrialFigures& b, double tolerance);

/// Follows plans through a window, from its initial state: with their controls and gains, within
/// the bounds of the controls. So plans that violate constraints, and those whose states do not
/// follow from each other, can be compared.
class PlanTrial {
 public:
  /// The problem of a window, which has to outlive it.
  explicit PlanTrial(const ShootingProblem& window);

  /// A plan of the window's shape. Where the gains of its first knot act, its first state need not
  /// be that of the window.
  TrialFigures follow(const Trajectory& plan, const Feedback& feedback);

 private:
  Evaluator evaluator_;
  SingleRollout rollout_;
  Evaluation evaluation_;
};

}  // namespace conddp
