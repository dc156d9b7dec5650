#pragma once

#include <vector>

#include "analysis/certificate/check.hpp"
#include "analysis/certificate/reduced_gradient.hpp"
#include "analysis/certificate/solution_claims.hpp"
#include "analysis/derivatives/node_derivatives.hpp"

namespace conddp {

/// The model of a sweep at a trajectory that rounding cannot tell from the answer's.
struct DisplacedModel {
  Trajectory trajectory;
  std::vector<NodeDerivatives> derivatives;
  /// How many times the difference of the two models rounding may be.
  double margin = 1;
};

/// Whether the feedback K and feedforward k of an answer are those of a Riccati sweep at its
/// trajectory, with the regularisation that it states and Gauss-Newton or exact Hessians: a sweep
/// of the certificate's own is compared knot by knot. Controls with a row of zeros in K are held,
/// as they may be where u + k is at a bound. None where the sweep depends on what the answer does
/// not state: penalties or active rows of constraints, or a regularisation of the states.
/// `derivatives`, Gauss-Newton `hessians`, `gap` (ndx x N) and `policy` are those at the
/// trajectory. Where `displaced` is given, entries of the model may be off by what changes on the
/// way there.
std::vector<Check> check_gains(const ShootingProblem& problem, const SolutionClaims& claims,
                               const std::vector<NodeDerivatives>& derivatives,
                               const std::vector<Eigen::MatrixXd>& hessians,
                               const Eigen::MatrixXd& gap, const RiccatiPolicy& policy,
                               const DisplacedModel* displaced = nullptr);

/// Whether they solve, to the tolerances of check_gains, the equations along the certificate's own
/// policy, without regularization: a sweep along them is then the same one, and need not be made.
bool are_gains_of_policy(const ShootingProblem& problem, const SolutionClaims& claims,
                         const std::vector<NodeDerivatives>& derivatives,
                         const Eigen::MatrixXd& gap, const RiccatiPolicy& policy);

}  // namespace conddp
