#pragma once

#include <memory>
#include <optional>

#include "solvers/riccati/adjoint.hpp"
#include "solvers/riccati/backward_sweep.hpp"

namespace conddp {

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
