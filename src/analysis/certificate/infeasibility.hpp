#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/certificate/second_order.hpp"
#include "analysis/derivatives/node_derivatives.hpp"

namespace conddp {

/// Share of the violation ‖d‖ of hard constraints that moves of the controls could remove, to first
/// order:
///   Σ_i |∂‖d‖/∂u_i| s_i / ‖d‖.
/// An adjoint pass, whose states follow from the controls, differentiates the distances d = g −
/// Π(g) of the values from their sets. The range s_i is the distance that a control can move
/// downhill to its bound. Without a bound, it is the largest size of any control, at least 1. Below
/// 1, no such move satisfies the linearized constraints, because distances from convex sets lie
/// above their tangents. Controls without a bound may move further, which violation_model() shows.
/// `values` are those of all constraint rows.
double attainable_share(const ShootingProblem& problem, const Trajectory& trajectory,
                        const std::vector<NodeDerivatives>& derivatives,
                        const Eigen::VectorXd& values);

/// Second-order model of the least-violation problem (violation_problem) at a trajectory with these
/// gaps (ndx x N). The cost is ½‖d‖².
SecondOrder violation_model(const ShootingProblem& problem, const Trajectory& trajectory,
                            const Eigen::MatrixXd& gaps);

/// Largest value of these shares at a point of least violation.
inline constexpr double kLeastViolationShare = 0.01;

}  // namespace conddp
