#pragma once

#include <array>
#include <optional>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/options.hpp"
#include "solvers/iterate/merit_model.hpp"
#include "solvers/riccati/adjoint.hpp"

namespace conddp {

/// What a line search found.
struct LineSearchResult {
  bool accepted = false;
  double step = 0;
  double expected_decrease = 0;  ///< of the merit, to first order
  double actual_decrease = 0;
  int trials = 0;
  bool by_rounding = false;  ///< the decrease is too small for the merit to tell
  int first_bad_knot = -1;   ///< where the first trial with a non-finite result lost it
  /// Of an accepted rollout: its cost with the augmentation. It leaves 1 − step of the gaps, or
  /// none where gaps are closed.
  std::optional<double> rollout_cost;

  /// That the last trial is accepted.
  void accept(double length, double expected, double actual, bool hidden) {
    accepted = true;
    step = length;
    expected_decrease = expected;
    actual_decrease = actual;
    by_rounding = hidden;
  }
};

/// Step lengths of the trials in one rollout, a lane each: `next_step` and its halves. `next_step`
/// ← the one after them.
std::array<double, kLaneWidth> lane_steps(double& next_step);

/// Armijo's rule on the merit over the step lengths 1, ½, ¼, ..., tried kLaneWidth at a time in the
/// lanes of one rollout. The largest acceptable one is taken, but, as the lanes tell at no cost,
/// its half instead where that lowers the merit more (down to 1/8). A trial that is not finite is
/// rejected. The first step is tried alone, in less time than the lanes need, as long as most
/// searches of late took it; it is taken then where the merit falls by a third of the first-order
/// decrease: on the parabola through both, its half lowers the merit less.
///
/// Where the model's step meets no bound the first-order decrease of a step α is
/// −α (∇J·d − ν Σ‖gap‖₁). Otherwise it
/// is that of the controls which the rollout really applied (Bertsekas' rule for projected steps),
/// −Σ ∇_u Lᵀ (δu_α − K δx_α) − α (Σ λᵀ gap − ν Σ‖gap‖₁), with the adjoint along that policy.
///
/// Where the decrease of the first step is lost in the merit's rounding, Armijo's rule is blind:
/// then that step passes if the merit changes by no more than rounding, and is marked so. The
/// caller has to see stationarity fall, or take the step back.
class LineSearch {
 public:
  LineSearch(const ShootingProblem& problem, const SolverOptions::LineSearch& options);

  /// On acceptance `trajectory` becomes the new iterate. `first_step` is the longest one tried.
  LineSearchResult run(Evaluator& evaluator, const MeritModel& merit, const Adjoint& adjoint,
                       const Eigen::MatrixXd& gap, const Feedback& feedback,
                       const RolloutOptions& rollout, double first_step, Trajectory& trajectory);

  /// Forgets how the last search went.
  void reset() { confidence_ = kMostConfidence; }

 private:
  /// Where a search is: what it starts from and follows.
  struct Ray {
    const MeritModel& merit;
    const Adjoint& adjoint;
    const Eigen::MatrixXd& gap;
    const Feedback& feedback;
    const RolloutOptions& rollout;
    const Trajectory& from;
  };
  bool try_alone(Evaluator& evaluator, const Ray& ray, double step, LineSearchResult& result);
  bool try_lanes(Evaluator& evaluator, const Ray& ray, double first_step, double& next_step,
                 LineSearchResult& result);
  bool accepts_lane(const Ray& ray, int lane, double step, bool first, LineSearchResult& result);
  bool half_is_better(int lane, double half, double actual, const MeritModel& merit) const;
  bool applies_slope(const Ray& ray) const;
  double expected_decrease(const Ray& ray, double step);
  double applied_slope(const Ray& ray);

  /// A counter with saturation, as of branch predictors: one short step in a row of full ones
  /// changes nothing, two in a row do.
  static constexpr int kMostConfidence = 3, kEnoughConfidence = 2;

  SolverOptions::LineSearch options_;
  StateManifold manifold_;
  LaneRollout lanes_;
  SingleRollout trial_;            ///< or one of the lanes
  Eigen::VectorXd dx_, followed_;  ///< scratch: δx, and K δx
  int confidence_ = kMostConfidence;
};

}  // namespace conddp
