#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Share of the motion above which the error of a grid's steps is reported: a tenth.
inline constexpr double kCoarse = 0.1;

/// Error of a grid's steps: the sum of the distances between each step's end and the exact motion
/// from its planned state, estimated by halving the step. The figures belong to the state component
/// with the largest error relative to the motion.
struct GridError {
  double relative = 0;     ///< `sum` / `way`; infinite if halved steps are not finite
  double sum = 0;          ///< largest absolute partial sum over the nodes, in the state's unit
  double way = 0;          ///< range of motion of this and like quantities (motion_scale())
  int entry = -1;          ///< entry of the tangent vector
  int knot = -1;           ///< the step with the largest error in that component
  std::vector<int> worst;  ///< up to kWorst steps with the largest errors in it; all if infinite
  double of_worst = 0;     ///< sum of the absolute values of these errors
  static constexpr std::size_t kWorst = 8;
};

/// Range of motion from the initial state for each entry of the tangent vector. Entries with the
/// same unit share the largest one; entries without a unit use their own. Infinite if nothing
/// moves.
Eigen::VectorXd motion_scale(const ShootingProblem& problem, const Trajectory& trajectory);

/// Error of the steps along a motion. Returns nullopt if an implicit step has no solution.
/// Instantaneous, discrete and contact-implicit knots do not count.
std::optional<GridError> grid_error(const ShootingProblem& problem, const Trajectory& trajectory);

/// Relative error of the same motion if each step is divided into as many `parts` by `rule`, by
/// default its own, estimated at the worst steps of `error`. Returns nullopt if the rule does not
/// support the state space or an implicit step has no solution.
std::optional<double> error_by(const ShootingProblem& problem, const Trajectory& trajectory,
                               const GridError& error, std::optional<Integrator> rule, int parts);

/// Error of a grid that does not resolve its motion. Its steps are off by more than kCoarse of the
/// motion, and so is a replay with feedback in halves of these steps. Returns nullopt if the grid
/// is fine enough or a replay is impossible.
std::optional<GridError> coarse_grid(const ShootingProblem& problem, const Trajectory& trajectory,
                                     const std::vector<Eigen::MatrixXd>& gains);

}  // namespace conddp
