#pragma once

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/stages/gap_transport.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "solvers/stages/value.hpp"

namespace conddp {

/// What a sweep adds to its model or to its gains.
struct SweepRegularization {
  RegularizationKind kind = RegularizationKind::proximal;
  double weight = 0;

  /// Whether it is a cost of the model, so that the policy is that model's minimum.
  bool in_model() const { return weight > 0 && kind == RegularizationKind::proximal; }
  /// Whether gains are those of another matrix than the model's.
  bool in_gains() const { return weight > 0 && kind != RegularizationKind::proximal; }
};

/// Where the linear terms of as many parameters as the state has entries begin below those of the
/// state, which is on a lane, and how many rows there are then.
int parameter_row(const ShootingProblem& problem);
int parametric_rows(const ShootingProblem& problem);

/// What the stages of a sweep read.
struct SweptHorizon {
  const Linearization& linearization;
  const Trajectory& trajectory;
  const Gaps& gaps;
  const ControlBounds& bounds;
};

/// The step of a sweep at one knot, in three parts, and its memory: the next value goes through the
/// dynamics, a solver minimises the stage, and the value of the resulting policy is formed.
class StageSweep {
 public:
  /// `parametric`: with room for a stage's linear terms of parameters.
  explicit StageSweep(const ShootingProblem& problem, bool parametric = false);

  /// Fills q() from the value at the next node.
  void propagate(const SweptHorizon& horizon, int k, const ValueFunction& next);
  /// Lets the solver minimise the stage; fills feedback.k and feedback.K of the knot.
  bool solve(const SweptHorizon& horizon, int k, SweepRegularization regularization,
             StageSolver& stages, Feedback& feedback);
  /// The same without regularisation, with parameters: `Qxu` has parametric_rows. `segment`: see
  /// StageProblem.
  bool solve(const SweptHorizon& horizon, int k, const Eigen::Ref<const Eigen::MatrixXd>& Qxu,
             int segment, StageSolver& stages, Feedback& feedback);
  /// The value at the knot. `true_gains`: K comes from second derivatives without regularisation.
  /// False where the value is not finite.
  bool form_value(ValueFunction& value, const Eigen::VectorXd& k, bool true_gains);

  const ActionValue& q() const { return q_; }
  /// K transposed (ndx x nu), below it from parameter_row on that of parameters, and one row more.
  LaneMatrix& Kt() { return Kt_; }

 private:
  bool solve(const StageProblem& stage, StageSolver& stages, Feedback& feedback);

  ValuePropagation propagation_;
  ActionValue q_;
  LaneMatrix columns_;  ///< nz x nu: control columns of Q_zz, regularised
  LaneMatrix Kt_;
  LaneMatrix M_;       ///< ndx x nu
  Eigen::VectorXd w_;  ///< nu
};

}  // namespace conddp
