#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/evaluation/linearization.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/stages/gap_transport.hpp"

namespace conddp {

/// Co-states of an iterate and the gradient of its Lagrangian
///   L = Σ cost + Σ λ_{k+1}ᵀ (f(x_k, u_k) ⊖ x_{k+1}),
/// along a policy δu = v + K δx: with ∇_u L = ℓ_u + f_uᵀ λ_{k+1},
///   λ_N = ∇ℓ_N, λ_k = ℓ_x + f_xᵀ λ_{k+1} + Kᵀ ∇_u L.
/// λ_k is the derivative of the cost to go by x_k where the controls follow the policy, and ∇_u L
/// that by v_k. K has no rows for controls that stand at a bound; so ∇_u L is zero in the others at
/// the same iterates for every K. But with K = 0 the co-states grow
/// as the free motion does, without bound on a robot that stands, and with them what rounding
/// leaves of ∇_u L. Open gaps on curved spaces transport λ from x_{k+1} to f(x_k, u_k) on the way
/// (GapTransport).
class Adjoint {
 public:
  Adjoint(const ShootingProblem& problem, const ControlBounds& bounds);

  /// `trajectory` is the one that was linearised.
  void compute(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
               const Feedback& feedback);

  /// ndx x (N + 1): column k is λ_k.
  const Eigen::MatrixXd& costates() const { return costates_; }
  /// ndx x (N + 1): ∇_x L at these co-states, −Kᵀ times what K passes on of ∇_u L.
  const Eigen::MatrixXd& state_gradient() const { return state_gradient_; }
  /// ∇_u L of all knots, one after the other.
  const Eigen::VectorXd& gradient() const { return gradient_; }
  /// The same without the controls that stand at a bound: what K passes on to the states.
  const Eigen::VectorXd& followed_gradient() const { return followed_; }
  /// Σ λ_{k+1}ᵀ gap_k: the cost's first-order change as the gaps are closed along the policy.
  double gap_slope() const { return gap_slope_; }
  /// A bound on what rounding does to the total cost: of the sum itself, and of the states, whose
  /// relative error reaches the cost through the co-states.
  double cost_rounding(const Linearization& linearization, const Trajectory& trajectory) const;

 private:
  const ControlBounds* bounds_;
  Eigen::MatrixXd costates_, state_gradient_;
  Eigen::VectorXd gradient_, followed_, next_, pulled_, scratch_;
  double gap_slope_ = 0;
};

}  // namespace conddp
