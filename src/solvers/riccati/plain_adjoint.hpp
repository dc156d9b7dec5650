#pragma once

#include <memory>
#include <optional>

#include "solvers/riccati/adjoint.hpp"
#include "solvers/riccati/backward_sweep.hpp"

namespace conddp {

/// A second opinion of an iterate's stationarity, by an adjoint pass along the policy of the costs
/// alone. The gains of an augmented Lagrangian, or of stages that keep rows, are as stiff as their
/// penalties: they put what is left of ∇L into the states' part, −Kᵀ∇_u L, and ∇_u L along them
/// may be small far from where it is small along others.
class PlainAdjoint {
 public:
  PlainAdjoint(const ShootingProblem& problem, const ControlBounds& bounds);

  /// ‖∇_u L‖∞ at these multipliers of the constraints (a number a row), projected on the control
  /// bounds. None where the costs have no minimum along the linear dynamics, however regularised.
  std::optional<double> stationarity(Evaluator& evaluator, const Trajectory& trajectory,
                                     const Gaps& gaps,
                                     const SolverOptions::Regularization& regularization,
                                     const Eigen::VectorXd& multipliers);

  /// The largest derivative of the cost by a state or control, at the last `stationarity`.
  double cost_gradient() const { return cost_gradient_; }
  /// Of the last `stationarity` that was found.
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
  std::vector<Eigen::VectorXd> cost_gradients_;  ///< nz of each node
  double cost_gradient_ = 0;
};

}  // namespace conddp
