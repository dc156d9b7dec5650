#pragma once

#include <limits>

#include <Eigen/Core>

#include "ocp/problem/trajectory.hpp"

namespace conddp {

class ShootingProblem;

/// Quality of a trajectory as an answer, found from the trajectory itself. Figures that cannot be
/// evaluated are NaN.
struct AnswerCheck {
  double cost = std::numeric_limits<double>::quiet_NaN();
  /// max ‖f(x_k, u_k) ⊖ x_{k+1}‖∞, or the distance of x_0 from the initial state if that is larger.
  double gap = std::numeric_limits<double>::quiet_NaN();
  /// ‖∇_u L‖∞ over the entries that no bound balances.
  double stationarity = std::numeric_limits<double>::quiet_NaN();
  /// Largest violation of a control bound or distance of a constraint from its set.
  double constraint = std::numeric_limits<double>::quiet_NaN();
  /// Largest product of a multiplier and the distance from its bound.
  double complementarity = std::numeric_limits<double>::quiet_NaN();
};

/// Measures the answers of all solvers alike, whatever they report about themselves.
///
/// Multipliers come from an adjoint pass along the trajectory with a policy computed here:
///   λ_N = ∇ℓ_N,  ∇_u L = ℓ_u + f_uᵀ λ_{k+1},  λ_k = ℓ_x + f_xᵀ λ_{k+1} + Kᵀ ∇_u L.
/// The gains K are those of a plain Riccati recursion on the Gauss-Newton model of the trajectory.
/// ∇_u L vanishes at the same trajectories for all K, but without feedback, rounding grows as an
/// unstable motion does. A control within `bound_tolerance`·max(1, |bound|) of a bound that the
/// descent direction would cross counts for complementarity instead of stationarity.
///
/// Constraints other than control bounds have further multipliers ν, which a trajectory alone does
/// not determine. They are taken from the answer, one number per constraint row; without them,
/// stationarity and complementarity are NaN. L then includes the terms νᵀg.
AnswerCheck check_answer(const ShootingProblem& problem, const Trajectory& trajectory,
                         double bound_tolerance = 1e-6,
                         const Eigen::VectorXd& constraint_multipliers = {});

}  // namespace conddp
