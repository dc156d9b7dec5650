#pragma once

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/stages/gap_transport.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "solvers/stages/value.hpp"

namespace conddp {

/// Data that the stages of a sweep read.
struct SweptHorizon {
  const Linearization& linearization;
  const Trajectory& trajectory;
  const Gaps& gaps;
  const ControlBounds& bounds;
};

/// The step of a sweep at one knot, in three parts, with its workspace: the next value goes through
/// the dynamics, a solver minimizes the stage, and the value of the resulting policy is formed.
class StageSweep {
 public:
  explicit StageSweep(const ShootingProblem& problem);

  /// Fills q() from the value at the next node.
  void propagate(const SweptHorizon& horizon, int k, const ValueFunction& next);
  /// Lets the solver minimize the stage with the weight of SolverOptions::Regularization; fills
  /// feedback.k and feedback.K of the knot.
  bool solve(const SweptHorizon& horizon, int k, double regularization, StageSolver& stages,
             Feedback& feedback);
  /// Forms the value at the knot. `minimizes`: K minimizes the stage in the entries that it does
  /// not leave out. False if the value is not finite.
  bool form_value(ValueFunction& value, const Eigen::VectorXd& k, bool minimizes);

  const ActionValue& q() const { return q_; }

 private:
  ValuePropagation propagation_;
  ActionValue q_;
  LaneMatrix Kt_;      ///< K transposed (ndx x nu), and one more row
  LaneMatrix M_;       ///< ndx x nu
  Eigen::VectorXd w_;  ///< nu
};

}  // namespace conddp
