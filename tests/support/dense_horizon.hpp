#pragma once

#include <vector>

#include <Eigen/Dense>

#include "ocp/evaluation/evaluator.hpp"
#include "support/conic_problems.hpp"
#include "support/random_numbers.hpp"

namespace conddp::testing {

/// The linear-quadratic model of a whole horizon in dense matrices: ½ zᵀ H z + gᵀ z of the
/// z = (δx, δu) of all nodes, one after the other, with E z = e, which says δx_0 = 0 and
/// ∂x⁺/∂z_k z_k + gap_k = δx_{k+1}. For flat spaces. Nothing is shared with the sweeps.
struct DenseHorizon {
  /// Gaps that are not `open` count as closed.
  DenseHorizon(const Linearization& linearization, bool open);

  Eigen::MatrixXd H, E;
  Eigen::VectorXd g, e;
  /// z = S U + s of all controls U, one after the other.
  Eigen::MatrixXd S;
  Eigen::VectorXd s;
  int ndx = 0;
  std::vector<int> nu;      ///< of each node, 0 of the last one
  std::vector<int> offset;  ///< of each node's z

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
  /// The minimum with A z + b = 0, from the KKT system of all unknowns.
  Optimum minimum(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) const;
  Optimum minimum() const { return minimum(Eigen::MatrixXd(0, size()), Eigen::VectorXd(0)); }
};

/// The constraint rows of all nodes: rows of the problem x size of z.
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
  /// Puts it into the model at z = 0, as it is there.
  void add_to(Linearization& linearization) const;
};

/// C z between bounds at the nodes first … last, which have as many controls. C has the columns of
/// the state and those of the control, if any.
Added affine_rows(const Eigen::MatrixXd& C, const ShootingProblem& problem, int first, int last,
                  double lower, double upper);

/// The problem with the same number of such rows at every node, whose C is all ones.
ShootingProblem rows_at_all_nodes(const LinearQuadratic& lq, int rows, double lower, double upper);
/// The penalty that an augmentation makes of them, with the values of a linearisation.
DensePenalty penalty_of_rows(const ShootingProblem& problem, const Linearization& linearization,
                             const Augmentation& augmentation);

/// Random numbers for a flat problem's linearisation: convex costs, dynamics that do not grow by
/// much, gaps, constraint values and their derivatives.
void randomize(const ShootingProblem& problem, RandomNumbers& random, Linearization& linearization);

}  // namespace conddp::testing
