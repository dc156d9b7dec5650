#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solvers/riccati/leg_joint.hpp"
#include "solvers/riccati/parametric_leg.hpp"

namespace conddp {

/// Into how many legs sweeps cut the horizon, and how many threads sweep them. Results depend on
/// the former alone, to rounding.
struct Legs {
  int count = 1;
  int threads = 1;
};

/// A Riccati sweep by legs, which can be swept side by side: all but the last one parametrically
/// (ParametricLeg), after which joints (LegJoint) find the states and co-states at their ends. So
/// the policy's step through the linear model is that of the sweep from end to start. As weights at
/// the ends of legs the values of the sweep before are taken, so that gains are near those of that
/// sweep, and equal as values settle.
class LegSweep {
 public:
  LegSweep(const ShootingProblem& problem, const Legs& legs);
  ~LegSweep();

  /// The first knots of up to as many legs as knots, and the number of knots. A knot of a
  /// parametric leg takes about twice the work of another; so the last leg is twice as long as the
  /// others.
  static std::vector<int> split(int knots, int legs);

  /// Takes the values that a whole sweep has found as weights.
  void start_from(const std::vector<ValueFunction>& values);
  /// Sweeps without regularisation with a policy that is affine. Returns the knot whose stage has
  /// no minimum or is not finite, −1 where all went well, and nothing where only a whole sweep can
  /// tell: before the first of them, and where the values have changed too much since the one
  /// before.
  std::optional<int> run(const SweptHorizon& horizon, StagePolicy& policy, Feedback& feedback,
                         std::vector<ValueFunction>& values, std::vector<Eigen::MatrixXd>& Quu);

 private:
  struct Team;
  int sweep_last(const SweptHorizon& horizon, StagePolicy& policy, Feedback& feedback,
                 std::vector<ValueFunction>& values, std::vector<Eigen::MatrixXd>& Quu);
  bool join(const std::vector<ValueFunction>& values);

  int knots_;
  bool started_ = false;
  std::vector<ParametricLeg> legs_;  ///< all but the last
  std::vector<LegJoint> joints_;     ///< their ends
  std::vector<char> swept_;
  StageSweep last_;
  int bad_knot_ = -1;
  std::vector<ValueFunction> true_values_;  ///< at the ends of legs
  Eigen::VectorXd start_;
  std::unique_ptr<Team> team_;
};

}  // namespace conddp
