#pragma once

#include <optional>

#include "solvers/iterate/iterate.hpp"
#include "solvers/riccati/plain_adjoint.hpp"

namespace conddp {

/// Whether a stationarity under tolerance is so along other gains than those of the last sweep,
/// too, with nearly the same co-states: along the gains of the costs alone where constraints have
/// stiff ones, else along none, where that is well conditioned. And whether it is small beside the
/// cost: with constraints beside its largest derivative, without them by what is left to gain. If
/// it is not, the solve goes on to a goal that should be enough.
class StationarityCheck {
 public:
  StationarityCheck(const ShootingProblem& problem, const ControlBounds& bounds,
                    const SolverOptions& options, bool constrained);

  /// The share of the cost that may be left to gain; and where an answer ends before its goal, or
  /// its goal can be no smaller.
  static constexpr double kMostGain = 1e-4, kMostGainAtEnd = 10 * kMostGain;

  /// At the start of a solve: the goal is the tolerance.
  void reset() {
    goal_ = options_.tolerances.stationarity;
    agreed_ = false;
  }
  /// What the stationarity has to fall to.
  double goal() const { return goal_; }
  /// Looks at an iterate that meets the goal, with the multipliers of all constraint rows where the
  /// solver has them. False, with a smaller goal, where it is not stationary along the other gains,
  /// or its co-states are not those along them.
  bool confirm(const Iterate& iterate, const Eigen::VectorXd* multipliers);
  /// Looks at the share of the cost that a Newton step would gain. False, with a smaller goal,
  /// where it is large: the gain falls as the square of the stationarity. Where that is at its
  /// least goal, flat costs remain: the solve goes on while there is much to gain.
  bool confirm_gain(const Iterate& iterate, double share);
  /// The co-states along the other gains, where the iterate is stationary along them, too, but its
  /// own co-states are apart from them. Null where they are not, or where `confirm` has just said
  /// so. They stand until the next look.
  const Adjoint* better(const Iterate& iterate, const Eigen::VectorXd* multipliers);

 private:
  /// Stationarity along the other gains and distance of the co-states, in what is allowed; zero
  /// where there are no others.
  struct Apart {
    double stationarity = 0, costates = 0;
  };
  bool ask_for_less(const Iterate& iterate, double excess);
  Apart compare(const Iterate& iterate, const Eigen::VectorXd* multipliers);
  const Adjoint& other() const;
  std::optional<double> reduced_stationarity(const Iterate& iterate, double stationarity);

  const SolverOptions& options_;
  std::optional<PlainAdjoint> plain_;  ///< where there are constraints
  std::optional<Adjoint> free_;        ///< elsewhere, along no_feedback_
  std::optional<Feedback> no_feedback_;
  double goal_;
  bool agreed_ = false;  ///< at the last look
};

}  // namespace conddp
