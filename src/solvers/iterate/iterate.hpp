#pragma once

#include <cmath>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/common/iteration_record.hpp"
#include "solvers/common/options.hpp"
#include "solvers/common/solve_record.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/iterate/ddp_recipe.hpp"
#include "solvers/iterate/hessian_switch.hpp"
#include "solvers/riccati/adjoint.hpp"
#include "solvers/stages/gap_transport.hpp"

namespace conddp {

/// The merit φ = J + ν Σ‖gap‖₁ around an iterate. With closed gaps, only the cost remains.
struct MeritModel {
  double cost = 0;      ///< J of the iterate
  double gap_norm = 0;  ///< Σ‖gap‖₁ of the iterate, also of rows (OpenGapSearch)
  double penalty = 0;   ///< ν, large enough to make closing gaps a descent
  double slope = 0;     ///< ∇J·d of the full model step
  bool slope_within_bounds = false;  ///< that step meets no bound
  double rounding = 0;               ///< size of J's rounding errors
  double value() const { return cost + penalty * gap_norm; }
  /// Derivative of φ along the step: gaps shrink by (1 − α).
  double merit_slope() const { return slope - penalty * gap_norm; }
  /// True if the step initially lowers the merit, as far as rounding shows.
  bool descends() const { return merit_slope() < 0 || hidden(merit_slope()); }
  /// True if rounding hides a change of this size.
  bool hidden(double change) const { return std::abs(change) <= tuning::kVisible * rounding; }
  /// Armijo's rule: a trial reaches kArmijo of the expected first-order decrease. The first trial
  /// also passes if rounding hides both decreases.
  bool passes(double expected, double actual, bool first) const {
    if (expected > 0 && actual >= tuning::kArmijo * expected) return true;
    return first && hidden(expected) && hidden(actual);
  }
};

/// State of a solve: a trajectory, its derivatives and co-states, and which of these are up to
/// date.
struct Iterate {
  Iterate(const ShootingProblem& problem, const ControlBounds& bounds, Evaluator& evaluator,
          const DdpRecipe& recipe, const SolverOptions& options, SolveRecord& record);

  /// Called at the start of a solve.
  void reset();
  /// Computes derivatives, co-states along a policy and, if wanted, exact Hessians. Sets
  /// `linearized` to true if all of them are finite.
  void differentiate(const Feedback& feedback, const Augmentation* augmentation);
  /// Ends the solve because the iterate is not finite, and restores the one before the last step.
  /// Returns false.
  bool end_diverged();

  /// ‖∇_u L‖∞, projected on the control bounds.
  Extremum stationarity() const { return bounds.projected_norm(adjoint.gradient(), trajectory); }
  /// max ‖f(x_k, u_k) ⊖ x_{k+1}‖∞ and its knot.
  Extremum largest_gap() const;
  /// Writes stationarity and gap into a row of the log.
  void describe(IterationRecord& row) const;

  SolveTimes& times() { return record_.result.times; }

  const ControlBounds& bounds;
  Evaluator& evaluator;
  Trajectory trajectory;
  Trajectory before;  ///< restored when a step is taken back
  Linearization linearization;
  Gaps gaps;
  Adjoint adjoint;
  HessianSwitch hessian;
  bool linearized = false;      ///< the linearization belongs to the trajectory
  bool differentiated = false;  ///< its dynamics and costs do; the rest is not computed yet
  double exact_below;           ///< gaps up to this use exact second derivatives

 private:
  bool is_finite() const;

  SolveRecord& record_;
  bool open_gaps_;
};

}  // namespace conddp
