#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/evaluation/linearization.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/stages/gap_transport.hpp"

namespace conddp {

/// Co-states of an iterate and the gradient of its Lagrangian
///   L = Σ cost + Σ λ_{k+1}ᵀ (f(x_k, u_k) ⊖ x_{k+1}),
/// along a policy δu = v + K δx: with ∇_u L = ℓ_u + f_uᵀ λ_{k+1},
///   λ_N = ∇ℓ_N, λ_k = ℓ_x + f_xᵀ λ_{k+1} + Kᵀ ∇_u L.
/// λ_k is the derivative of the cost to go with respect to x_k if the controls follow the policy.
/// ∇_u L is the derivative with respect to v_k. K has zero rows for controls at a bound, so that
/// every K makes ∇_u L vanish for the other controls at the same iterates. With K = 0, however, the
/// co-states grow like the free motion, without bound for a standing robot, and so does the
/// rounding error of ∇_u L. On curved spaces, an open gap transports λ from x_{k+1} to f(x_k, u_k)
/// (GapTransport).
class Adjoint {
 public:
  Adjoint(const ShootingProblem& problem, const ControlBounds& bounds);

  /// `trajectory` is the linearization point.
  void compute(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
               const Feedback& feedback);

  /// ndx x (N + 1): column k is λ_k.
  const Eigen::MatrixXd& costates() const { return costates_; }
  /// ndx x (N + 1): ∇_x L at these co-states, equal to −Kᵀ followed_gradient().
  const Eigen::MatrixXd& state_gradient() const { return state_gradient_; }
  /// ∇_u L of all knots, stacked.
  const Eigen::VectorXd& gradient() const { return gradient_; }
  /// The same with zeros for controls at a bound: the part that K passes on to the states.
  const Eigen::VectorXd& followed_gradient() const { return followed_; }
  /// Σ λ_{k+1}ᵀ gap_k: the first-order change of the cost when the gaps are closed along the
  /// policy.
  double gap_slope() const { return gap_slope_; }
  /// Bound on the rounding error of the total cost: the error of the sum itself, and that of the
  /// states, whose relative error reaches the cost through the co-states.
  double cost_rounding(const Linearization& linearization, const Trajectory& trajectory) const;

 private:
  const ControlBounds* bounds_;
  Eigen::MatrixXd costates_, state_gradient_;
  Eigen::VectorXd gradient_, followed_, next_, pulled_, scratch_;
  double gap_slope_ = 0;
};

/// A second test of an iterate's stationarity, by an adjoint pass along the policy for the costs
/// only. The gains of an augmented Lagrangian, or of stages that enforce rows, are as stiff as
/// their penalties. They move the residual of ∇L into the state part, −Kᵀ∇_u L. Therefore ∇_u L
/// along these gains may be small far from points where it is small along others.
class PlainAdjoint {
 public:
  PlainAdjoint(const ShootingProblem& problem, const ControlBounds& bounds);

  /// ‖∇_u L‖∞ at these constraint multipliers (one per row), projected on the control bounds. Empty
  /// if the costs lack a minimum along the linear dynamics with any regularization.
  std::optional<double> stationarity(Evaluator& evaluator, const Trajectory& trajectory,
                                     const Gaps& gaps, const Eigen::VectorXd& multipliers);

  /// Largest derivative of the cost with respect to a state or control, from the last call of
  /// stationarity().
  double cost_gradient() const { return cost_gradient_; }
  /// The adjoint of the last successful stationarity().
  const Adjoint& adjoint() const { return adjoint_; }

 private:
  double largest_cost_gradient();

  const ShootingProblem& problem_;
  const ControlBounds& bounds_;
  Augmentation lagrangian_;
  Linearization linearization_;
  BackwardSweep sweep_;
  std::unique_ptr<StageSolver> stages_;
  Feedback feedback_;
  Adjoint adjoint_;
  std::vector<Eigen::VectorXd> cost_gradients_;  ///< nz entries per node
  double cost_gradient_ = 0;
};

}  // namespace conddp
