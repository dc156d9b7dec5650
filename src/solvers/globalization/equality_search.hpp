#pragma once

#include <utility>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/globalization/line_search.hpp"
#include "solvers/riccati/linear_rollout.hpp"

namespace conddp {

/// Line search for stages that enforce equality constraints. Each step length α has two trials: the
/// rollout of the sweep's policy, and the linear model's own step x ⊕ α δx, u + α δu, whose knots
/// are evaluated in parallel. Gains that must satisfy rows with the last few controls amplify every
/// model error; the straight step opens gaps instead. The better trial counts.
///
/// The merit is the exact penalty J + w θ with θ = Σ‖gap‖₁ + Σ‖c‖₁. Its derivative along the step
/// is ∇J·d − w θ, since the step satisfies the linear equations of both.
class EqualitySearch {
 public:
  explicit EqualitySearch(const ShootingProblem& problem);

  /// θ of gaps (ndx x N) and constraint values (all rows of the problem).
  double infeasibility(const Eigen::MatrixXd& gap, const Eigen::VectorXd& values) const;
  /// Fills the merit's slope, penalty and rounding for the step around an iterate; the merit
  /// already contains its cost and θ. `multipliers`: those in the linearization's gradients;
  /// `curvature`: dᵀHd with its Hessians. The penalty follows from the model: a share of w θ covers
  /// ∇J·d + ½ dᵀ∇²L d (Nocedal, Wright, equation 18.36). It is at least half of its previous value.
  void measure(const Linearization& linearization, const Trajectory& trajectory,
               const Augmentation& augmentation, const Eigen::VectorXd& multipliers,
               const LinearRollout& step, double curvature, MeritModel& merit) const;
  /// Armijo's rule over the step length `first_step` and its halves. On acceptance, `trajectory`
  /// becomes the new iterate. Changes that rounding hides are treated as in LineSearch.
  LineSearchResult run(Evaluator& evaluator, const MeritModel& merit,
                       const Linearization& linearization, const LinearRollout& step,
                       const Feedback& feedback, double first_step, Trajectory& trajectory);

 private:
  void move(const LinearRollout& step, double length, const Trajectory& from);
  double value(Evaluator& evaluator, const MeritModel& merit, const Trajectory& trial);
  std::pair<double, const Trajectory*> better_trial(Evaluator& evaluator, const MeritModel& merit,
                                                    int lane);
  bool try_lane(Evaluator& evaluator, const MeritModel& merit, const LinearRollout& step, int lane,
                double length, bool first, LineSearchResult& result, Trajectory& trajectory);
  bool accepts(const MeritModel& merit, double length, double value, bool first,
               LineSearchResult& result) const;
  template <class Function>
  void for_each_row(const Eigen::VectorXd& values, Function&& function) const;

  const ShootingProblem& problem_;
  StateManifold manifold_;
  LaneRollout lanes_;
  Evaluation evaluation_;
  Trajectory straight_, rolled_;  ///< the two trials
  Eigen::VectorXd dx_;            ///< scratch
};

}  // namespace conddp
