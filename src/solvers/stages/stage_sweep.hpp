#pragma once

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/stages/gap_transport.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "solvers/stages/value.hpp"

namespace conddp {

/// First row of the linear terms of the parameters, and the total number of rows. These terms
/// follow those of the state at the next lane; there are as many parameters as state entries.
int parameter_row(const ShootingProblem& problem);
int parametric_rows(const ShootingProblem& problem);

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
  /// `parametric`: reserves room for a stage's linear terms of parameters.
  explicit StageSweep(const ShootingProblem& problem, bool parametric = false);

  /// Fills q() from the value at the next node.
  void propagate(const SweptHorizon& horizon, int k, const ValueFunction& next);
  /// Lets the solver minimize the stage with the weight of SolverOptions::Regularization; fills
  /// feedback.k and feedback.K of the knot.
  bool solve(const SweptHorizon& horizon, int k, double regularization, StageSolver& stages,
             Feedback& feedback);
  /// The same without regularization and with parameters: `Qxu` has parametric_rows. `segment`: see
  /// StageProblem.
  bool solve(const SweptHorizon& horizon, int k, const Eigen::Ref<const Eigen::MatrixXd>& Qxu,
             int segment, StageSolver& stages, Feedback& feedback);
  /// Forms the value at the knot. `minimizes`: K minimizes the stage in the entries that it does
  /// not leave out. False if the value is not finite.
  bool form_value(ValueFunction& value, const Eigen::VectorXd& k, bool minimizes);

  const ActionValue& q() const { return q_; }
  /// K transposed (ndx x nu). The gains of parameters begin at row parameter_row; one more row
  /// follows.
  LaneMatrix& Kt() { return Kt_; }

 private:
  bool solve(const StageProblem& stage, StageSolver& stages, Feedback& feedback);

  ValuePropagation propagation_;
  ActionValue q_;
  LaneMatrix Kt_;
  LaneMatrix M_;       ///< ndx x nu
  Eigen::VectorXd w_;  ///< nu
};

}  // namespace conddp
