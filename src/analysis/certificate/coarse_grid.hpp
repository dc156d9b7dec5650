#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Errors of the steps of a grid beyond this share of the motion are worth a word: a tenth.
inline constexpr double kCoarse = 0.1;

/// The error of a grid's steps: the sum over the planned steps of how far each ends from where the
/// equations lead from its planned state, estimated by halves of the step. The component of the
/// state in which it is largest, relative to the motion.
struct GridError {
  double relative =
      0;           ///< `sum` by `way`; infinite where halves of a step leave the finite numbers
  double sum = 0;  ///< largest absolute value of the sum up to any node, in the state's unit
  double way = 0;  ///< how far this and like quantities move (motion_scale())
  int entry = -1;  ///< of the tangent vector
  int knot = -1;   ///< the step with the largest error in that component
};

/// By entry of the tangent vector how far a motion goes from its beginning: the farthest of all
/// with the same unit, each its own where they have none. Infinite where nothing moves.
Eigen::VectorXd motion_scale(const ShootingProblem& problem, const Trajectory& trajectory);

/// The error of steps along a motion if each one is made in as many `parts` by `rule`, its own
/// where none is given. Nothing where a rule does not support the state space or an implicit step
/// has no solution. Knots without time, discrete and contact-implicit ones do not count.
std::optional<GridError> grid_error(const ShootingProblem& problem, const Trajectory& trajectory,
                                    std::optional<Integrator> rule = std::nullopt, int parts = 1);

/// The error of a grid that does not resolve its motion: the steps are off by more than kCoarse of
/// the motion, and a replay in halves of these steps, with feedback, is so, too. Nothing where the
/// grid is fine enough or there is no replay.
std::optional<GridError> coarse_grid(const ShootingProblem& problem, const Trajectory& trajectory,
                                     const std::vector<Eigen::MatrixXd>& gains);

}  // namespace conddp
