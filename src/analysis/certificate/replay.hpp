#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// How far a motion goes from the planned one.
struct ReplayRun {
  double deviation = 0;    ///< largest entry of x ⊖ x_k over all nodes
  int knot = -1;           ///< its node
  int entry = -1;          ///< its entry of the tangent vector
  double final_state = 0;  ///< largest entry at the last node
  double relative = 0;     ///< largest entry relative to how far that entry moves, at least 0.01
  int saturated = 0;       ///< controls that feedback drove into a bound
  int lost_at = -1;        ///< the knot from which on the motion is not finite
};

/// A limit of the robot, or of what contacts can do, that the motion breaks.
struct BrokenLimit {
  std::string quantity;  ///< "position of elbow", "velocity of elbow", "pull of LF"
  std::string unit;
  double excess = 0;     ///< largest distance beyond the limit
  int knot = -1;         ///< where
  double time = 0;       ///< s
  bool between = false;  ///< whether the excess at the knots alone is smaller
};

/// What the plan does on a grid that is finer than its own.
struct Replay {
  std::string impossible;  ///< why there is none; empty otherwise
  int substeps = 0;        ///< steps for each one of the plan
  ReplayRun controls;      ///< the controls alone
  ReplayRun feedback;      ///< u = u_k + K_k (x ⊖ x_k), on the bounds, held over the knot
  std::vector<BrokenLimit> broken;  ///< with feedback
};

/// Plays controls back in steps of dt / substeps with the problem's integrator, from the initial
/// state: with the controls alone and with gains K. Limits of joints and contacts that pull are
/// looked for at every one of these steps, also those that the problem does not ask for.
Replay replay(const ShootingProblem& problem, const Trajectory& trajectory,
              const std::vector<Eigen::MatrixXd>& gains, int substeps = 10);

/// How far the controls alone lead from the planned states on that grid: the largest entry of x ⊖
/// x_k over all nodes. Infinite where the motion leaves the finite numbers or there is no replay.
double replay_error(const ShootingProblem& problem, const Trajectory& trajectory,
                    int substeps = 10);

/// How far the motion with feedback leads from the planned states on a grid of dt / substeps: the
/// largest entry over all nodes, each by its own entry of `scale`. Infinite where the motion leaves
/// the finite numbers, nothing where there is no replay.
std::optional<double> replay_with_feedback(const ShootingProblem& problem,
                                           const Trajectory& trajectory,
                                           const std::vector<Eigen::MatrixXd>& gains, int substeps,
                                           const Eigen::VectorXd& scale);

}  // namespace conddp
