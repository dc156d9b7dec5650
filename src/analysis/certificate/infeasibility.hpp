#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/certificate/second_order.hpp"
#include "analysis/derivatives/node_derivatives.hpp"

namespace conddp {

/// How much of the violation ‖d‖ of hard constraints, where d = g − Π(g) are the distances of their
/// values from their sets, moves of the controls could take away to first order, as a share of it:
///   Σ_i |∂‖d‖/∂u_i| s_i / ‖d‖,
/// by an adjoint pass in which states follow from the controls; s_i is how far a control can go,
/// downhill, to its bound, and without a bound its largest size anywhere, at least 1. Below 1 no
/// such move satisfies the linearised constraints: distances from convex sets lie above their
/// tangents. Controls without a bound may go further: the share is at least what the best step
/// along their steepest descent p takes of ‖d‖², (pᵀp)² / (‖J p‖² ‖d‖²), J the Jacobian of the rows
/// that are outside. `values` are those of all constraint rows.
double attainable_share(const ShootingProblem& problem, const Trajectory& trajectory,
                        const std::vector<NodeDerivatives>& derivatives,
                        const Eigen::VectorXd& values);

/// The model of second order of the problem of the least violation (violation_problem) at a
/// trajectory with these gaps (ndx x N): its cost is ½‖d‖².
SecondOrder violation_model(const ShootingProblem& problem, const Trajectory& trajectory,
                            const Eigen::MatrixXd& gaps);

/// What those shares may be at a point of least violation.
inline constexpr double kLeastViolationShare = 0.01;

}  // namespace conddp
