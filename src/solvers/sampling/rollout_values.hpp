#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "solvers/sampling/control_splines.hpp"

namespace conddp {

/// Value of a rollout; both numbers are NaN if a state, a cost or a constraint is not finite.
struct RolloutValue {
  double cost = 0;  ///< of the problem, soft constraints included
  /// Euclidean norm of the distances of all hard constraints from their sets, terminal ones
  /// included. Rollouts satisfy the dynamics and control bounds.
  double violation = 0;

  bool finite() const;
};

/// Completes a trajectory with given controls of the actuators: writes its states, and controls
/// that follow from them, such as contact forces. False if no such motion is found. Called from
/// several threads.
using Simulate = std::function<bool(Trajectory&)>;

/// Values of many rollouts of control splines from the initial state. Allocates nothing after
/// construction, unless a simulator does; values do not depend on the number of threads.
class RolloutValues {
 public:
  /// Evaluates the problem's own steps, with one sample per lane, or motions of a simulator.
  RolloutValues(const ControlSplines& splines, int threads, Simulate simulate = nullptr);
  ~RolloutValues();
  RolloutValues(const RolloutValues&) = delete;
  RolloutValues& operator=(const RolloutValues&) = delete;

  /// Evaluates samples: a column of `theta` and an entry of `values` each.
  void evaluate(const Eigen::MatrixXd& theta, std::vector<RolloutValue>& values);
  /// The trajectory of one sample; false if it is not finite.
  bool roll_out(const double* theta, Trajectory& trajectory);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace conddp
