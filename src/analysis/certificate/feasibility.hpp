#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "analysis/certificate/second_order.hpp"
#include "analysis/certificate/solution_claims.hpp"
#include "analysis/derivatives/node_derivatives.hpp"

namespace conddp {

/// The largest of some quantities, and its place.
struct Worst {
  double value = 0;
  double size = 0;  ///< size of its terms
  int knot = -1;
  int entry = -1;

  /// NaN counts as the largest, and loses its sign.
  void meet(double candidate, double candidate_size, int k, int i) {
    if (std::isnan(value) || !(std::isnan(candidate) || candidate > value)) return;
    *this = {std::abs(candidate), std::abs(candidate_size), k, i};
  }
};

/// Violations of bounds and constraints by an answer, and multipliers that do not match them.
struct Feasibility {
  Worst violation;  ///< distance from a set
  Worst product;    ///< multiplier times distance from its bound; infinite without a bound
  Worst negative;   ///< distance of a multiplier from its set's normal cone, which must be zero
};

/// (v, t) minus the nearest point of the second-order cone ‖v‖ ≤ t.
Eigen::VectorXd beyond_cone(const Eigen::VectorXd& s);

/// Measures the feasibility of an answer. Worst::entry is the index of a control for its bounds;
/// for a constraint, constraint_of returns the index in the problem. `values` are g of all
/// constraint rows.
Feasibility measure_feasibility(const ShootingProblem& problem, const SolutionClaims& claims,
                                const Eigen::VectorXd& values);
/// Index of the constraint in the problem, or −1 if `worst` does not belong to a constraint.
int constraint_of(const Worst& worst);

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
