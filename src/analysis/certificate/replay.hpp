#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "ocp/knot/knot_model.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Controls at the ends of a step; they are equal unless the controls are linear.
struct StepControl {
  const double *begin, *end;
};

class CollocationStep;

/// Moves the states of one knot model in steps of any length, by its integrator or another one, in
/// scalar arithmetic. The collocation slopes of a plan belong to its whole steps; those of other
/// steps are solved for.
class ReplayStep {
 public:
  /// The model must outlive this object.
  explicit ReplayStep(const KnotModel& model);
  /// Uses another rule. Throws std::invalid_argument if that is a collocation and the state space
  /// is curved.
  ReplayStep(const KnotModel& model, Integrator rule);
  ~ReplayStep();

  /// The system without collocation slopes.
  const System& system() const { return *system_; }
  /// Evaluates the system at (x, u), before a step from there.
  const SystemData<double>& look(const double* x, const double* u);
  /// Moves x by a step of dt from the evaluated point, in place. x is NaN if an implicit step has
  /// no solution.
  void go(const StepControl& u, double dt, double* x);

 private:
  std::shared_ptr<const System> system_;
  Integrator integrator_;
  bool linear_;
  std::unique_ptr<SystemData<double>> data_;
  std::optional<IntegratorWorkspace<double>> work_;
  std::unique_ptr<CollocationStep> implicit_;
};

/// Deviation of a replayed motion from the planned one.
struct ReplayRun {
  double deviation = 0;    ///< largest entry of x ⊖ x_k over all nodes
  int knot = -1;           ///< its node
  int entry = -1;          ///< its entry of the tangent vector
  double final_state = 0;  ///< largest entry at the last node
  double relative = 0;     ///< largest entry relative to its range of motion, at least 0.01
  int saturated = 0;       ///< controls that feedback drove into a bound
  int lost_at = -1;        ///< knot whose step is not finite, or −1
};

/// A limit of the robot or of its contacts that the motion violates.
struct BrokenLimit {
  std::string quantity;  ///< "position of elbow", "velocity of elbow", "pull of LF"
  std::string unit;
  double excess = 0;     ///< largest distance beyond the limit
  int knot = -1;         ///< knot of the largest excess
  double time = 0;       ///< s
  bool between = false;  ///< true if the excess at the knots alone is smaller
};

/// Motion of the plan on a grid that is finer than its own.
struct Replay {
  std::string impossible;  ///< reason if a replay is impossible; otherwise empty
  int substeps = 0;        ///< steps per step of the plan
  ReplayRun controls;      ///< with the controls alone
  ReplayRun feedback;      ///< u = u_k + K_k (x ⊖ x_k), clamped to the bounds, held over the knot
  std::vector<BrokenLimit> broken;  ///< limits violated with feedback
};

/// Largest distance from the initial state of each entry of the tangent vector.
Eigen::VectorXd motion_range(const ShootingProblem& problem, const Trajectory& trajectory);

/// Replays controls in steps of dt / substeps with the problem's integrator, from the initial
/// state: with the controls alone and with gains K. Every step is checked for violated joint limits
/// and pulling contacts, even if the problem does not constrain them.
Replay replay(const ShootingProblem& problem, const Trajectory& trajectory,
              const std::vector<Eigen::MatrixXd>& gains, int substeps = 10);

/// Deviation from the planned states on that grid with the controls alone: the largest entry of x ⊖
/// x_k over all nodes. Infinite if the motion leaves the finite numbers or cannot be replayed.
double replay_error(const ShootingProblem& problem, const Trajectory& trajectory,
                    int substeps = 10);

/// Deviation from the planned states with feedback on a grid of dt / substeps: the largest entry
/// over all nodes, each relative to its entry of `scale`. Infinite if the motion leaves the finite
/// numbers, nullopt if it cannot be replayed.
std::optional<double> replay_with_feedback(const ShootingProblem& problem,
                                           const Trajectory& trajectory,
                                           const std::vector<Eigen::MatrixXd>& gains, int substeps,
                                           const Eigen::VectorXd& scale);

}  // namespace conddp
