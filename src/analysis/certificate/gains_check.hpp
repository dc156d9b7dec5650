#pragma once

#include <vector>

#include "analysis/certificate/check.hpp"
#include "analysis/certificate/node_derivatives.hpp"
#include "analysis/certificate/solution_claims.hpp"

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
/// `derivatives`, Gauss-Newton `hessians` and `gap` (ndx x N) are those at the trajectory. Where
/// `displaced` is given, entries of the model may be off by what changes on the way there.
std::vector<Check> check_gains(const ShootingProblem& problem, const SolutionClaims& claims,
                               const std::vector<NodeDerivatives>& derivatives,
                               const std::vector<Eigen::MatrixXd>& hessians,
                               const Eigen::MatrixXd& gap,
                               const DisplacedModel* displaced = nullptr);

}  // namespace conddp
