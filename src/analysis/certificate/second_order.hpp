#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>

#include "analysis/derivatives/node_derivatives.hpp"
#include "ocp/problem/problem.hpp"
#include "ocp/problem/trajectory.hpp"

namespace conddp {

/// Sign of the Lagrangian's Hessian on the tangent space of the active constraints.
enum class Curvature {
  positive,   ///< in every direction, with weakly active rows left out: a strict local minimum
  negative,   ///< in a direction that no constraint forbids: no minimum
  undecided,  ///< zero to rounding, or negative only where weakly active rows may forbid it
};

/// Model of second order at a trajectory: cost, dynamics and active constraints, with exact
/// Hessians of the Lagrangian. Figures are in the unit of the costs.
struct SecondOrder {
  Curvature curvature = Curvature::undecided;
  /// Decrease of the cost that Newton's step along the active constraints promises, as far as the
  /// inactive ones let it go.
  double gain = 0;
  /// Size of the change of the cost that closing gaps and violations promises.
  double repair = 0;
  /// Sum of |∂L/∂u| times the range of each control; 0 without constraints.
  double slope = 0;
  /// What the costs amount to: the sum of their sizes, and no more than moves of all states and
  /// controls by their ranges change.
  double cost_size = 0;
  double negligible = 0;  ///< what is nothing
  double resolution = 0;  ///< what cannot be told from nothing
  /// Where the curvature is not positive, the least eigenvalue of a stage's reduced Hessian,
  /// relative to the terms that it is the sum of, and its knot; else infinite, and −1.
  double least = std::numeric_limits<double>::infinity();
  int knot = -1;
  /// Where the curvature is negative, a direction (δx_k, δu_k) of each node along the dynamics and
  /// active constraints, by one range at most and as far as inactive constraints let it go; and
  /// ½ dᵀ∇²L d.
  std::vector<Eigen::VectorXd> direction;
  double bend = 0;

  /// Largest share of the cost that is left to gain, to repair or to slide.
  double share() const;
  /// Share of the cost that rounding can hide.
  double hidden_share() const;
  /// Multiplies all figures in the unit of the costs.
  void scale(double factor);
};

/// The point that is judged.
struct JudgedPoint {
  const ShootingProblem& problem;
  const Trajectory& trajectory;
  const Eigen::MatrixXd& gap;                        ///< ndx x N
  const std::vector<NodeDerivatives>& derivatives;   ///< at the trajectory
  const std::vector<Eigen::MatrixXd>& gauss_newton;  ///< Hessians of the costs, nz x nz
  const Eigen::VectorXd& values;                     ///< of all constraint rows
  const Eigen::VectorXd& multipliers;                ///< of all constraint rows
  /// Co-states (ndx x (N + 1)) and ∂L/∂u of an adjoint pass with these multipliers.
  const Eigen::MatrixXd& costates;
  const std::vector<Eigen::VectorXd>& control_gradient;
  double cost_size = 0;   ///< sum of the absolute values of all costs
  double negligible = 0;  ///< of the costs, what counts as nothing
};

/// Riccati recursion on the null space of the active constraints (Laine, Tomlin 2019), from the
/// trajectory, its derivatives and multipliers alone. The reduced Hessian of the whole horizon is
/// positive definite where that of each stage is.
SecondOrder second_order(const JudgedPoint& point);

}  // namespace conddp
