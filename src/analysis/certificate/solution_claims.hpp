#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"
#include "ocp/problem/trajectory.hpp"
#include "solvers/common/options.hpp"

namespace conddp {

/// Numbers that an answer claims; NaN if it leaves one open.
struct SolutionClaims {
  static constexpr double kOpen = std::numeric_limits<double>::quiet_NaN();

  explicit SolutionClaims(const ShootingProblem& problem);

  Trajectory trajectory;
  std::vector<double> times;  ///< N + 1
  bool converged = false;
  std::string status;
  double cost = kOpen;
  std::vector<std::pair<std::string, double>> cost_by_name;
  double stationarity = kOpen;
  double gap = kOpen;
  double constraint = kOpen;
  double complementarity = kOpen;
  SolverOptions::Tolerances tolerances;
  Eigen::MatrixXd costates;        ///< ndx x (N + 1)
  Eigen::MatrixXd state_gradient;  ///< ndx x (N + 1): ∇_x of the Lagrangian
  /// Multipliers of the control bounds, one vector per knot; zero if the answer does not state any.
  std::vector<Eigen::VectorXd> lower_multipliers, upper_multipliers;
  /// Multipliers of the constraints, one per constraint row of the problem.
  Eigen::VectorXd multipliers;
  std::vector<Eigen::MatrixXd> gains;        ///< K, nu x ndx per knot
  std::vector<Eigen::VectorXd> feedforward;  ///< k, nu per knot
  double gain_regularization = kOpen;        ///< regularization of their sweep
  std::vector<std::string> tangent_names;    ///< names of tangent coordinates, for places
};

}  // namespace conddp
