#pragma once

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/stages/gap_transport.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "solvers/stages/value.hpp"

namespace conddp {

/// Regularization that a sweep adds to its model or to its gains.
struct SweepRegularization {
  RegularizationKind kind = RegularizationKind::proximal;
  double weight = 0;

  /// True if it is a cost of the model, so that the policy minimizes that model.
  bool in_model() const { return weight > 0 && kind == RegularizationKind::proximal; }
  /// True if the gains belong to a matrix other than the model's.
  bool in_gains() const { return weight > 0 && kind != RegularizationKind::proximal; }
};

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
  /// Lets the solver minimize the stage; fills feedback.k and feedback.K of the knot.
  bool solve(const SweptHorizon& horizon, int k, SweepRegularization regularization,
             StageSolver& stages, Feedback& feedback);
  /// The same without regularization and with parameters: `Qxu` has parametric_rows. `segment`: see
  /// StageProblem.
  bool solve(const SweptHorizon& horizon, int k, const Eigen::Ref<const Eigen::MatrixXd>& Qxu,
             int segment, StageSolver& stages, Feedback& feedback);
  /// Forms the value at the knot. `true_gains`: K comes from unregularized second derivatives.
  /// False if the value is not finite.
  bool form_value(ValueFunction& value, const Eigen::VectorXd& k, bool true_gains);

  const ActionValue& q() const { return q_; }
  /// K transposed (ndx x nu). The gains of parameters begin at row parameter_row; one more row
  /// follows.
  LaneMatrix& Kt() { return Kt_; }

 private:
  bool solve(const StageProblem& stage, StageSolver& stages, Feedback& feedback);

  ValuePropagation propagation_;
  ActionValue q_;
  LaneMatrix columns_;  ///< nz x nu: control columns of Q_zz, regularized
  LaneMatrix Kt_;
  LaneMatrix M_;       ///< ndx x nu
  Eigen::VectorXd w_;  ///< nu
};

}  // namespace conddp
