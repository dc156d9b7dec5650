#pragma once

#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// Cost and violation of following a plan through a window, by the window's own problem.
struct TrialFigures {
  double violation = 0;  ///< largest violation of a hard constraint; infinite if the motion
                         ///< diverges
  double cost = 0;
};

/// True if the violation is smaller by more than a tolerance, or equal within it and the cost is
/// smaller.
bool is_better(const TrialFigures& a, const TrialFigures& b, double tolerance);

/// Rolls out plans through a window from its initial state, with their controls and gains, clipped
/// to the control bounds. This makes plans comparable that violate constraints or have gaps.
class PlanTrial {
 public:
  /// Problem of a window, which must outlive the trial.
  explicit PlanTrial(const ShootingProblem& window);

  /// `plan` has the window's shape. Its first state may differ from the window's where the gains of
  /// its first knot act.
  TrialFigures follow(const Trajectory& plan, const Feedback& feedback);

 private:
  Evaluator evaluator_;
  SingleRollout rollout_;
  Evaluation evaluation_;
};

}  // namespace conddp
