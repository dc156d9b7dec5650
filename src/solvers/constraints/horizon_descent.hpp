#pragma once

#include <vector>

#include <Eigen/Core>

#include "solvers/constraints/horizon_constraints.hpp"
#include "solvers/constraints/penalized_bounds.hpp"
#include "solvers/riccati/linear_rollout.hpp"

namespace conddp {

/// A point in the linear model of the horizon that moves downhill, from sweep to sweep: Newton's
/// method on the augmented Lagrangian with penalties for the control bounds, both convex and
/// piecewise quadratic, with an exact line search. So it converges where sets of active rows and
/// bounds, taken as they come, alternate.
class HorizonDescent {
 public:
  HorizonDescent(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Begins with a step, whose gaps are those of the iterate. The model is that of the iterate.
  void start(const LinearRollout& step, const Trajectory& trajectory,
             const Eigen::VectorXd& gradient, const BackwardSweep& sweep,
             HorizonConstraints& constraints, Linearization& linearization);
  /// Moves the point towards the minimum of the model around it, and the model with it. Returns
  /// whether that was the minimum of the penalised model.
  bool advance(const LinearRollout& minimum, HorizonConstraints& constraints,
               Linearization& linearization);
  /// Takes the penalties for bounds out of the model, and holds controls where they pushed.
  void leave(ActiveSet& active_set, Linearization& linearization);
  /// δu = k + K δx ← the point, with the K that there is.
  void write(Feedback& feedback) const;

 private:
  double step_length(const LinearRollout& minimum, HorizonConstraints& constraints,
                     const Linearization& linearization);

  const ControlBounds& bounds_;
  int ndx_;
  PenalizedBounds penalties_;
  std::vector<Eigen::VectorXd> point_;  ///< (δx, δu) of each node
  Eigen::VectorXd d_, product_;
};

}  // namespace conddp
