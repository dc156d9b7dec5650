#pragma once

#include <vector>

#include <Eigen/Dense>

#include "ocp/evaluation/evaluator.hpp"
#include "support/conic_problems.hpp"
#include "support/random_numbers.hpp"

namespace conddp::testing {

/// The linear-quadratic model of a whole horizon in dense matrices, for flat spaces: ½ zᵀ H z + gᵀ
/// z with stacked z = (δx, δu) of all nodes, subject to E z = e. The equations are δx_0 = 0 and
/// ∂x⁺/∂z_k z_k + gap_k = δx_{k+1}. Independent of the sweeps.
struct DenseHorizon {
  /// Gaps count as closed unless `open`.
  DenseHorizon(const Linearization& linearization, bool open);

  Eigen::MatrixXd H, E;
  Eigen::VectorXd g, e;
  /// z = S U + s of all stacked controls U.
  Eigen::MatrixXd S;
  Eigen::VectorXd s;
  int ndx = 0;
  std::vector<int> nu;      ///< of each node, 0 for the last
  std::vector<int> offset;  ///< of each node's part of z

  int nodes() const { return static_cast<int>(nu.size()); }
  int size() const { return static_cast<int>(g.size()); }
  int nz(int k) const { return ndx + nu[k]; }
  /// The part of a node.
  Eigen::VectorXd at(const Eigen::VectorXd& z, int k) const { return z.segment(offset[k], nz(k)); }
  /// All parts in one vector.
  Eigen::VectorXd stack(const std::vector<Eigen::VectorXd>& z) const;

  struct Optimum {
    Eigen::VectorXd z;
    Eigen::MatrixXd costates;  ///< ndx x nodes: λ of x_k, with + λᵀ(x⁺ − x) in the Lagrangian
    Eigen::VectorXd multipliers;  ///< of the rows of A
  };
  /// Minimum subject to A z + b = 0, from the KKT system of all unknowns.
  Optimum minimum(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) const;
  Optimum minimum() const { return minimum(Eigen::MatrixXd(0, size()), Eigen::VectorXd(0)); }
};

/// Constraint rows of all nodes: rows of the problem x size of z.
Eigen::MatrixXd dense_constraints(const ShootingProblem& problem,
                                  const Linearization& linearization);

/// ½ Σ ρ dist²(C z + base, [lower, upper]), row by row.
struct DensePenalty {
  Eigen::MatrixXd C;
  Eigen::VectorXd base, penalty, lower, upper;

  /// C z + base minus the nearest point between the bounds.
  Eigen::VectorXd outside(const Eigen::VectorXd& z) const;
  double value(const Eigen::VectorXd& z) const;
  Eigen::VectorXd gradient(const Eigen::VectorXd& z) const;
  /// Adds the penalty at z = 0 to the model.
  void add_to(Linearization& linearization) const;
};

/// C z between bounds at the nodes first … last, which have equal numbers of controls. C has
/// columns for the state and, if any, the control.
Added affine_rows(const Eigen::MatrixXd& C, const ShootingProblem& problem, int first, int last,
                  double lower, double upper);

/// The problem with the same number of such rows at every node, with an all-ones C.
ShootingProblem rows_at_all_nodes(const LinearQuadratic& lq, int rows, double lower, double upper);
/// Penalty of these rows in an augmentation, with the values of a linearization.
DensePenalty penalty_of_rows(const ShootingProblem& problem, const Linearization& linearization,
                             const Augmentation& augmentation);

/// Randomizes a flat problem's linearization: convex costs, dynamics of moderate growth, gaps,
/// constraint values, and their derivatives.
void randomize(const ShootingProblem& problem, RandomNumbers& random, Linearization& linearization);

}  // namespace conddp::testing
