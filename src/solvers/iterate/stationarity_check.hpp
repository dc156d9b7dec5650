#pragma once

#include <optional>

#include "solvers/iterate/iterate.hpp"
#include "solvers/riccati/adjoint.hpp"

namespace conddp {

/// Checks a stationarity within tolerance in two ways. First, it should also hold along other gains
/// than those of the last sweep, with nearly the same co-states. With constraints, whose gains are
/// stiff, these are the gains of the costs alone; otherwise zero gains, if the gradient along them
/// is well-conditioned. Second, it should be small compared with the cost: with constraints,
/// compared with the cost's largest derivative; without them, by the remaining gain. If a check
/// fails, the solve continues to a smaller goal that should be enough.
class StationarityCheck {
 public:
  StationarityCheck(const ShootingProblem& problem, const ControlBounds& bounds,
                    const SolverOptions& options, bool constrained);

  /// Sets the goal to the tolerance at the start of a solve.
  void reset() {
    goal_ = options_.tolerances.stationarity;
    agreed_ = false;
  }
  /// Stationarity that the solve has to reach.
  double goal() const { return goal_; }
  /// Checks an iterate that meets the goal, with the multipliers of all constraint rows if the
  /// solver has them. If the iterate is not stationary along the other gains, or its co-states
  /// differ from those along them, returns false and lowers the goal.
  bool confirm(const Iterate& iterate, const Eigen::VectorXd* multipliers);
  /// Checks the share of the cost that a Newton step would gain. If it is large, returns false and
  /// lowers the goal: the gain falls as the square of the stationarity. At the least goal, flat
  /// costs remain: the solve continues while there is much to gain.
  bool confirm_gain(const Iterate& iterate, double share);
  /// Co-states along the other gains, if the iterate is stationary along them, too, but its own
  /// co-states differ. Null otherwise, or if `confirm` has just agreed. Valid until the next check.
  const Adjoint* better(const Iterate& iterate, const Eigen::VectorXd* multipliers);

 private:
  /// Stationarity along the other gains and distance of the co-states, as multiples of the allowed
  /// values; zero without other gains.
  struct Apart {
    double stationarity = 0, costates = 0;
  };
  bool ask_for_less(const Iterate& iterate, double excess);
  Apart compare(const Iterate& iterate, const Eigen::VectorXd* multipliers);
  const Adjoint& other() const;
  std::optional<double> reduced_stationarity(const Iterate& iterate, double stationarity);

  const SolverOptions& options_;
  std::optional<PlainAdjoint> plain_;  ///< with constraints
  std::optional<Adjoint> free_;        ///< without constraints, along no_feedback_
  std::optional<Feedback> no_feedback_;
  double goal_;
  bool agreed_ = false;  ///< the last `confirm` found agreement
};

}  // namespace conddp
