#pragma once

#include <array>
#include <optional>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/iterate/iterate.hpp"
#include "solvers/riccati/adjoint.hpp"

namespace conddp {

/// Result of a line search.
struct LineSearchResult {
  bool accepted = false;
  double step = 0;
  double expected_decrease = 0;  ///< of the merit, to first order
  double actual_decrease = 0;
  int trials = 0;
  bool by_rounding = false;  ///< the decrease is too small for the merit to resolve
  int first_bad_knot = -1;   ///< knot where the first non-finite trial failed
  /// Cost of an accepted rollout, including the augmentation. The rollout leaves 1 − step of the
  /// gaps; closed gaps stay closed.
  std::optional<double> rollout_cost;

  /// Records that the last trial is accepted.
  void accept(double length, double expected, double actual, bool hidden) {
    accepted = true;
    step = length;
    expected_decrease = expected;
    actual_decrease = actual;
    by_rounding = hidden;
  }
};

/// Step lengths of the trials in one rollout, one per lane: `next_step` and its halves. `next_step`
/// ← the length that follows them.
std::array<double, kLaneWidth> lane_steps(double& next_step);

/// Armijo's rule on the merit over the step lengths 1, ½, ¼, ..., tried kLaneWidth at a time in the
/// lanes of one rollout. The largest acceptable step is taken, unless its half lowers the merit
/// more, which the lanes show at no extra cost (down to 1/8). A trial that is not finite is
/// rejected. If the last search took its first step, this one is tried alone, which is faster than
/// the lanes. It is then taken if the merit falls by a third of the first-order
/// decrease: on the parabola through both, its half lowers the merit less.
///
/// If the model's step meets no bound, the first-order decrease of a step α is −α (∇J·d − ν
/// Σ‖gap‖₁). Otherwise it is that of the controls actually applied by the rollout (Bertsekas' rule
/// for projected steps), with the adjoint along that policy:
///   −Σ ∇_u Lᵀ (δu_α − K δx_α) − α (Σ λᵀ gap − ν Σ‖gap‖₁).
///
/// If rounding of the merit hides the decrease of the first step, Armijo's rule cannot judge it.
/// The step then passes if the merit changes by no more than rounding, and is marked accordingly.
/// The caller must verify that the stationarity falls, or undo the step.
class LineSearch {
 public:
  explicit LineSearch(const ShootingProblem& problem);

  /// On acceptance, `trajectory` becomes the new iterate. `first_step` is the longest step tried.
  LineSearchResult run(Evaluator& evaluator, const MeritModel& merit, const Adjoint& adjoint,
                       const Eigen::MatrixXd& gap, const Feedback& feedback,
                       const RolloutOptions& rollout, double first_step, Trajectory& trajectory);

  /// Forgets the outcome of previous searches.
  void reset() { alone_ = true; }

 private:
  /// The start of a search and the policy that it follows.
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

  StateManifold manifold_;
  LaneRollout lanes_;
  SingleRollout trial_;            ///< a single trial, or one of the lanes
  Eigen::VectorXd dx_, followed_;  ///< scratch: δx and K δx
  bool alone_ = true;              ///< the last search took its first step
};

}  // namespace conddp
