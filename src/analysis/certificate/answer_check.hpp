#pragma once

#include <limits>

#include <Eigen/Core>

#include "ocp/problem/trajectory.hpp"

namespace conddp {

class ShootingProblem;

/// What a trajectory is worth as an answer, found from the trajectory alone; not-a-number where it
/// cannot be evaluated.
struct AnswerCheck {
  double cost = std::numeric_limits<double>::quiet_NaN();
  /// max ‖f(x_k, u_k) ⊖ x_{k+1}‖∞, and how far x_0 is from the initial state.
  double gap = std::numeric_limits<double>::quiet_NaN();
  /// ‖∇_u L‖∞ where no bound balances it.
  double stationarity = std::numeric_limits<double>::quiet_NaN();
  /// Largest violation of a bound on the control, or distance of a constraint from its set.
  double constraint = std::numeric_limits<double>::quiet_NaN();
  /// Largest multiplier of a bound times the control's distance from it.
  double complementarity = std::numeric_limits<double>::quiet_NaN();
};

/// The same measure for the answers of all solvers, whatever they say of themselves.
///
/// Multipliers come from an adjoint pass at the trajectory along a policy of this function's own:
/// λ_N = ∇ℓ_N, ∇_u L = ℓ_u + f_uᵀ λ_{k+1}, λ_k = ℓ_x + f_xᵀ λ_{k+1} + Kᵀ ∇_u L, with the gains K of
/// a plain Riccati recursion on the Gauss-Newton model of the trajectory. (∇_u L vanishes at the
/// same trajectories for every K; but without feedback rounding grows as an unstable motion does.)
/// A control within `bound_tolerance`·max(1, |bound|) of a bound that the descent direction would
/// cross counts for complementarity instead of stationarity.
///
/// A problem with constraints other than bounds on the control has further multipliers ν, which a
/// trajectory alone does not tell: they are the answer's own, one number a constraint row (without
/// them, stationarity and complementarity are not-a-number). L then has the terms νᵀg.
AnswerCheck check_answer(const ShootingProblem& problem, const Trajectory& trajectory,
                         double bound_tolerance = 1e-6,
                         const Eigen::VectorXd& constraint_multipliers = {});

}  // namespace conddp
