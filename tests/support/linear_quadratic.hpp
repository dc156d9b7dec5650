#pragma once

#include <memory>
#include <vector>

#include <Eigen/Dense>

#include "support/small_problems.hpp"

namespace conddp::testing {

/// A linear-quadratic problem in matrices, and the ShootingProblem made from it. Its two phases
/// have different numbers of controls.
struct LinearQuadratic {
  struct Knot {
    Eigen::MatrixXd A, B;
    Eigen::VectorXd c, Q, R, x_ref;  // Q and R are diagonals, scaled like the cost
  };
  int nx = 0;
  Eigen::VectorXd x0, Qf, xf_ref;
  std::vector<Knot> knots;
  std::unique_ptr<ShootingProblem> problem;

  /// Random problem from the seed, with `knots_per_phase` knots per number of controls, and all
  /// controls between `low` and `up`. A is scaled to the spectral radius unless that is 0:
  /// otherwise many states grow without bound.
  LinearQuadratic(unsigned seed, int nx_, std::vector<int> nu, int knots_per_phase, double low,
                  double up, double spectral_radius = 0);

  int N() const { return static_cast<int>(knots.size()); }

  /// Cost of states and controls without simulation.
  double cost(const Trajectory& t) const;

  /// Optimum without bounds, and the multipliers of the dynamics (column k + 1 for knot k), from
  /// the dense KKT system of all x_1 … x_N, u_0 … u_{N−1}.
  Trajectory dense_optimum(Eigen::MatrixXd* multipliers = nullptr) const;

  /// Gains of the textbook Riccati recursion.
  std::vector<Eigen::MatrixXd> riccati_gains() const;

  /// The cost as a dense quadratic ½ Uᵀ H U + gᵀ U + constant in all controls, with states
  /// eliminated.
  void condense(Eigen::MatrixXd& H, Eigen::VectorXd& g) const;
};

}  // namespace conddp::testing
