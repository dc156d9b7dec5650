#pragma once

#include <vector>

#include <Eigen/Core>

#include "solvers/constraints/horizon_constraints.hpp"
#include "solvers/constraints/penalized_bounds.hpp"
#include "solvers/riccati/linear_rollout.hpp"

namespace conddp {

/// A point in the linear model of the horizon that descends from sweep to sweep. The method is
/// Newton's with an exact line search, on the augmented Lagrangian with penalties for the control
/// bounds. Both are convex and piecewise quadratic. It therefore converges even if the sets of
/// active rows and bounds alternate under full steps.
class HorizonDescent {
 public:
  HorizonDescent(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Begins with a step that has the gaps of the iterate. The model is that of the iterate.
  void start(const LinearRollout& step, const Trajectory& trajectory,
             const Eigen::VectorXd& gradient, const BackwardSweep& sweep,
             HorizonConstraints& constraints, Linearization& linearization);
  /// Moves the point towards the minimum of the model around it, and the model with it. True if
  /// this was the minimum of the penalized model.
  bool advance(const LinearRollout& minimum, HorizonConstraints& constraints,
               Linearization& linearization);
  /// Removes the penalties for bounds from the model, and holds controls where they pushed.
  void leave(ActiveSet& active_set, Linearization& linearization);
  /// Writes the point as δu = k + K δx with the present K.
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
