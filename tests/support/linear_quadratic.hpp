#pragma once

#include <memory>
#include <vector>

#include <Eigen/Dense>

#include "support/small_problems.hpp"

namespace conddp::testing {

/// A linear-quadratic problem in matrices, beside the ShootingProblem made from it. The numbers of
/// controls differ between its two phases.
struct LinearQuadratic {
  struct Knot {
    Eigen::MatrixXd A, B;
    Eigen::VectorXd c, Q, R, x_ref;  // Q and R are diagonals, scaled as the cost is
  };
  int nx = 0;
  Eigen::VectorXd x0, Qf, xf_ref;
  std::vector<Knot> knots;
  std::unique_ptr<ShootingProblem> problem;

  /// Random numbers from the seed, `knots_per_phase` knots with each of the numbers of controls,
  /// all controls between `low` and `up`. A is scaled to the spectral radius if that is not 0: as
  /// they come, many states grow without bound.
  LinearQuadratic(unsigned seed, int nx_, std::vector<int> nu, int knots_per_phase, double low,
                  double up, double spectral_radius = 0);

  int N() const { return static_cast<int>(knots.size()); }

  /// Of states and controls as they are.
  double cost(const Trajectory& t) const;

  /// The optimum without bounds, and the dynamics' multipliers (column k + 1 of knot k), from the
  /// dense KKT system of all x_1 … x_N, u_0 … u_{N−1}.
  Trajectory dense_optimum(Eigen::MatrixXd* multipliers = nullptr) const;

  /// Gains of the textbook Riccati recursion.
  std::vector<Eigen::MatrixXd> riccati_gains() const;

  /// The cost as a dense quadratic ½ Uᵀ H U + gᵀ U + constant of all controls, states eliminated.
  void condense(Eigen::MatrixXd& H, Eigen::VectorXd& g) const;
};

}  // namespace conddp::testing
