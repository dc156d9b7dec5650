#pragma once

#include <vector>

#include "analysis/certificate/check.hpp"
#include "analysis/certificate/node_derivatives.hpp"
#include "analysis/certificate/solution_claims.hpp"

namespace conddp {

/// Whether the feedback K and feedforward k of an answer are those of a Riccati sweep at its
/// trajectory, with the regularisation that it states and Gauss-Newton or exact Hessians: a sweep
/// of the certificate's own is compared knot by knot. Controls with a row of zeros in K are held,
/// as they may be where u + k is at a bound. None where the sweep depends on what the answer does
/// not state: penalties or active rows of constraints, or a regularisation of the states.
/// `derivatives`, Gauss-Newton `hessians` and `gap` (ndx x N) are those at the trajectory.
std::vector<Check> check_gains(const ShootingProblem& problem, const SolutionClaims& claims,
                               const std::vector<NodeDerivatives>& derivatives,
                               const std::vector<Eigen::MatrixXd>& hessians,
                               const Eigen::MatrixXd& gap);

}  // namespace conddp
