#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/stages/active_set.hpp"
#include "solvers/stages/gap_transport.hpp"

namespace conddp {

/// Rollout of a sweep's policy through the linear model, its full step d = (δx, δu):
///   δx_0 = 0, δu = k + K δx, δx⁺ = G (f_x δx + f_u δu) + gap.
class LinearRollout {
 public:
  LinearRollout(const ShootingProblem& problem, const ControlBounds& bounds);

  /// With `clamp`, δu is clamped so that u + δu respects its bounds, as in the nonlinear rollout.
  void run(const Linearization& linearization, const Trajectory& trajectory, const Gaps& gaps,
           const Feedback& feedback, bool clamp);
  /// Recomputes the slope of the same step with the gradients of another linearization.
  void measure_slope(const Linearization& linearization);
  /// Computes the policy's response to the gaps alone: δu = K δx without k.
  void respond(const Linearization& linearization, const Gaps& gaps, const Feedback& feedback);

  /// The step at node k: dx (ndx), z = (δx, δu) (nz, without δu at the last node), and du (nu).
  auto dx(int k) const { return z_[k].head(ndx_); }
  const Eigen::VectorXd& z(int k) const { return z_[k]; }
  const std::vector<Eigen::VectorXd>& z() const { return z_; }
  auto du(int k) const { return z_[k].tail(z_[k].size() - ndx_); }
  /// Moves a trajectory by this share of the step, at all nodes at once.
  void apply(const StateManifold& manifold, double length, Trajectory& trajectory) const;
  /// ∇J·d: exact derivative of the cost along the rollout at α = 0.
  double slope() const { return slope_; }
  /// dᵀ Hessian d.
  double curvature(const Linearization& linearization) const;
  /// Shows every knot's step to the active set for revision (ActiveSet::revise). Returns the number
  /// of changed entries. `last` ← the last knot with a change, if any.
  int revise(ActiveSet& active_set, std::optional<int>& last) const;

 private:
  const ControlBounds& bounds_;
  int ndx_;
  std::vector<Eigen::VectorXd> z_;  ///< (δx, δu) of every node
  mutable Eigen::VectorXd moved_;   ///< scratch
  double slope_ = 0;
};

}  // namespace conddp
