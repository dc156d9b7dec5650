#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "solvers/riccati/linear_rollout.hpp"
#include "solvers/stages/stage_solver.hpp"

/// Segment sweeps, compared with the sequential sweep.
namespace conddp::testing {

/// A linearized iterate, swept in some number of segments.
class SegmentedIterate {
 public:
  /// Constraint rows enter as an augmented Lagrangian with this penalty.
  SegmentedIterate(const ShootingProblem& problem, const Trajectory& guess, Segments segments,
                   double penalty = 10)
      : problem_(problem),
        bounds_(problem),
        linearization_(problem),
        gaps_(problem),
        trajectory_(guess),
        sweep_(problem, bounds_, segments),
        stages_(box_stage(problem, segments.count)),
        rollout_(problem, bounds_),
        feedback(problem) {
    Evaluator evaluator(problem);
    Augmentation augmentation(problem);
    augmentation.penalty.setConstant(penalty);
    bounds_.clamp(trajectory_);
    evaluator.differentiate(trajectory_, linearization_,
                            problem.constraints().empty() ? nullptr : &augmentation);
    gaps_.set(linearization_, true);
  }

  const Eigen::MatrixXd& Quu(int k) const { return sweep_.Quu(k); }

  /// Finds the active set of each stage in a sequential sweep. False if a stage has no minimum.
  bool begin() { return run(false) < 0; }
  /// Sweeps another cost with that set; values at segment ends then belong to that cost.
  void sweep_another_cost() {
    const auto scale_later_nodes = [&](double factor) {
      for (int k = problem_.knots() / 2; k <= problem_.knots(); ++k)
        linearization_.knots[k].hessian.change() *= factor;
    };
    scale_later_nodes(4);
    EXPECT_LT(run(true), 0);
    scale_later_nodes(0.25);
  }
  /// Sweeps with that set and rolls out through the linear model.
  void sweep() {
    ASSERT_LT(run(true), 0);
    rollout_.run(linearization_, trajectory_, gaps_, feedback, false);
    costates.clear();
    for (int k = 1; k <= problem_.knots(); ++k)
      costates.emplace_back(sweep_.value(k).Vx + sweep_.value(k).Vxx * rollout_.dx(k));
  }
  /// Number of changes that a revision makes to the active set.
  int revise() {
    std::optional<int> last;
    return rollout_.revise(stages_->active_set(), last);
  }
  const std::vector<Eigen::VectorXd>& step() const { return rollout_.z(); }

 private:
  int run(bool hold) {
    return sweep_.run(linearization_, trajectory_, gaps_, {}, *stages_, feedback, hold);
  }

  const ShootingProblem& problem_;
  ControlBounds bounds_;
  Linearization linearization_;
  Gaps gaps_;
  Trajectory trajectory_;
  BackwardSweep sweep_;
  std::unique_ptr<StageSolver> stages_;
  LinearRollout rollout_;

 public:
  Feedback feedback;
  std::vector<Eigen::VectorXd> costates;  ///< of the nodes 1 … N
};

/// Largest difference relative to the largest number.
inline double relative_difference(const std::vector<Eigen::VectorXd>& a,
                                  const std::vector<Eigen::VectorXd>& b) {
  double off = 0, largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    off = std::max(off, (a[k] - b[k]).lpNorm<Eigen::Infinity>());
    largest = std::max(largest, b[k].lpNorm<Eigen::Infinity>());
  }
  return largest > 0 ? off / largest : off;
}

/// Expects that a segment sweep around an iterate gives the step and costates of the sequential
/// sweep, for any initial values at segment ends.
inline void expect_equal_by_segments(const ShootingProblem& problem, const Trajectory& guess,
                                     double tolerance = 1e-9) {
  SegmentedIterate one(problem, guess, {});
  ASSERT_TRUE(one.begin());
  one.sweep();
  const int changes = one.revise();
  for (const int segments : {2, 3, 5}) {
    if (segments > problem.knots()) continue;
    SCOPED_TRACE(std::to_string(segments) + " segments");
    SegmentedIterate several(problem, guess, {.count = segments});
    ASSERT_TRUE(several.begin());
    several.sweep_another_cost();
    several.sweep();
    EXPECT_LT(relative_difference(several.step(), one.step()), tolerance);
    EXPECT_LT(relative_difference(several.costates, one.costates), tolerance);
    EXPECT_EQ(several.revise(), changes);
    // Segments have their own gains: a sequential sweep did not replace them.
    const int end = SegmentSweep::split(problem.knots(), segments)[1];
    double gains = 0, changes_of_gains = 0;
    for (int k = 0; k < end; ++k) {
      gains += one.feedback.K[k].squaredNorm();
      changes_of_gains += (several.feedback.K[k] - one.feedback.K[k]).squaredNorm();
    }
    EXPECT_EQ(changes_of_gains > 0, gains > 0);
  }
}

}  // namespace conddp::testing
