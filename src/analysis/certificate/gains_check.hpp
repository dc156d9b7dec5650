#pragma once

#include <vector>

#include "analysis/certificate/check.hpp"
#include "analysis/certificate/lagrangian_gradient.hpp"
#include "analysis/certificate/solution_claims.hpp"
#include "analysis/derivatives/node_derivatives.hpp"

namespace conddp {

/// Sweep model at a trajectory that rounding cannot distinguish from the answer's.
struct DisplacedModel {
  Trajectory trajectory;
  std::vector<NodeDerivatives> derivatives;
  /// Rounding may be this multiple of the difference between the two models.
  double margin = 1;
};

/// Checks that the feedback K and feedforward k of an answer are those of a Riccati sweep at its
/// trajectory, with the regularization that it states and Gauss-Newton or exact Hessians. The
/// certificate compares its own sweep knot by knot. Controls with a zero row in K are held, which
/// is allowed if u + k is at a bound. Returns no checks if the sweep depends on data that the
/// answer does not state: penalties or active rows of constraints, or a regularization of the
/// states. `derivatives`, Gauss-Newton `hessians` and `gap` (ndx x N) are those at the
/// trajectory. If `displaced` is given, entries of the model may be off by their change at the
/// displaced trajectory.
std::vector<Check> check_gains(const ShootingProblem& problem, const SolutionClaims& claims,
                               const std::vector<NodeDerivatives>& derivatives,
                               const std::vector<Eigen::MatrixXd>& hessians,
                               const Eigen::MatrixXd& gap,
                               const DisplacedModel* displaced = nullptr);

}  // namespace conddp
