#pragma once

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/common/iteration_record.hpp"
#include "solvers/common/options.hpp"
#include "solvers/common/solve_record.hpp"
#include "solvers/iterate/ddp_recipe.hpp"
#include "solvers/iterate/hessian_switch.hpp"
#include "solvers/riccati/adjoint.hpp"
#include "solvers/stages/gap_transport.hpp"

namespace conddp {

/// Where a solve stands: a trajectory, its derivatives and co-states, and what of that is known.
struct Iterate {
  Iterate(const ShootingProblem& problem, const ControlBounds& bounds, Evaluator& evaluator,
          const DdpRecipe& recipe, const SolverOptions& options, SolveRecord& record);

  /// At the start of a solve.
  void reset();
  /// Derivatives, co-states along a policy, and exact Hessians where they are wanted. `linearized`
  /// tells whether all of them are finite.
  void differentiate(const Feedback& feedback, const Augmentation* augmentation);
  /// Ends the solve because something of the iterate is not finite; the one before the last step
  /// stands. Returns false.
  bool end_diverged();

  /// ‖∇_u L‖∞, projected on the control bounds.
  Extremum stationarity() const { return bounds.projected_norm(adjoint.gradient(), trajectory); }
  /// max ‖f(x_k, u_k) ⊖ x_{k+1}‖∞ and its knot.
  Extremum largest_gap() const;
  /// Writes both into a row of the log.
  void describe(IterationRecord& row) const;

  SolveTimes& times() { return record_.result.times; }

  const ControlBounds& bounds;
  Evaluator& evaluator;
  Trajectory trajectory;
  Trajectory before;  ///< what a step that is taken back goes back to
  Linearization linearization;
  Gaps gaps;
  Adjoint adjoint;
  HessianSwitch hessian;
  bool linearized = false;      ///< the linearisation belongs to the trajectory
  bool differentiated = false;  ///< its dynamics and costs do, the rest is still to be found
  double exact_below;           ///< gaps at which exact second derivatives begin

 private:
  bool is_finite() const;

  SolveRecord& record_;
  bool open_gaps_;
};

}  // namespace conddp
