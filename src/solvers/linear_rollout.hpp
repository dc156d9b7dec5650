#pragma once

#include <Eigen/Core>

#include "ocp/acts.hpp"
#include "solvers/backward_sweep.hpp"
#include "solvers/control_bounds.hpp"
#include "solvers/gap_transport.hpp"
#include "solvers/stage_policy.hpp"

namespace conddp {

/// What the quadratic model says of a sweep's full step d = (δx, δu).
struct ModelStep {
  double slope = 0;       ///< ∇J·d: exact derivative of the cost along the rollout at α = 0
  double curvature = 0;   ///< dᵀ Hessian d
  double multiplier = 0;  ///< largest |V_x + V_xx δx|: the dynamics' multipliers of the QP
};

/// Rolls a sweep's policy out through the linear model: δx_0 = 0, δu = k + K δx,
/// δx⁺ = G (f_x δx + f_u δu) + gap.
class LinearRollout {
 public:
  LinearRollout(const ShootingProblem& problem, const ControlBounds& bounds);

  /// With `clamp`, δu is cut where u + δu would leave its bounds, as the rollout proper does.
  ModelStep run(const Linearization& linearization, const Trajectory& trajectory,
                const Feedback& feedback, const BackwardSweep& sweep, bool open_gaps, bool clamp);

  /// Shows every knot's step, not cut off, to the policy for revision of its active set
  /// (StagePolicy::revise); returns how many entries changed.
  int revise(const Linearization& linearization, const Feedback& feedback, bool open_gaps,
             bool release, StagePolicy& policy);

 private:
  const ControlBounds& bounds_;
  GapTransport gap_;
  Eigen::VectorXd z_, dx_, product_, lambda_;
};

}  // namespace conddp
