// Descent in a horizon model, compared with the penalized function in dense matrices.
#include "solvers/constraints/horizon_descent.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/riccati/adjoint.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "support/dense_horizon.hpp"
#include "support/linear_quadratic.hpp"

namespace conddp::testing {
namespace {

/// Bound weights as multiples of the stage curvature, as in PenalizedBounds.
constexpr double kBoundWeight = 10;

/// A random model with penalties for rows and control bounds, and its descent.
struct Descent {
  explicit Descent(unsigned seed)
      : lq(1, 2 + static_cast<int>(seed % 3), {1, 2}, 3, -0.6, 0.6),
        problem(rows_at_all_nodes(lq, 3, -0.5, 0.5)),
        bounds(problem),
        linearization(problem),
        gaps(problem),
        trajectory(random_guess(problem, seed)),
        adjoint(problem, bounds),
        sweep(problem, bounds),
        stages(box_stage(problem)),
        feedback(problem),
        rollout(problem, bounds),
        augmentation(problem),
        constraints(problem),
        descent(problem, bounds) {
    RandomNumbers random(seed);
    randomize(problem, random, linearization);
    bounds.clamp(trajectory);
    gaps.set(linearization, true);
    for (double& weight : augmentation.penalty) weight = random.uniform(1, 1000);
    for (double& shift : augmentation.shift) shift = random.uniform(-0.5, 0.5);
    dense.emplace(linearization, true);
    rows = penalty_of_rows(problem, linearization, augmentation);
    rows.add_to(linearization);
    own.emplace(linearization, true);
    adjoint.compute(linearization, trajectory, gaps, feedback);
    EXPECT_EQ(run_sweep(), -1);  // for stage curvature and gains
    penalize_controls();
    constraints.start(linearization, &augmentation);
    rollout.respond(linearization, gaps, feedback);
    descent.start(rollout, trajectory, adjoint.gradient(), sweep, constraints, linearization);
  }
  int run_sweep() {
    stages->active_set().release();
    return sweep.run(linearization, trajectory, gaps, {}, *stages, feedback, true);
  }
  /// ½ w dist²(u + δu + ν/w, bounds), where ν balances the gradient at a bound.
  void penalize_controls() {
    const int n = bounds.size();
    controls = {Eigen::MatrixXd::Zero(n, dense->size()), Eigen::VectorXd(n), Eigen::VectorXd(n),
                Eigen::VectorXd(n), Eigen::VectorXd(n)};
    for (int k = 0, at = 0; k < problem.knots(); ++k)
      for (int i = 0; i < problem.nu(k); ++i, ++at) {
        const double u = trajectory.u(k)[i], slope = adjoint.gradient()[at];
        controls.C(at, dense->offset[k] + dense->ndx + i) = 1;
        controls.penalty[at] = kBoundWeight * sweep.Quu(k)(i, i);
        controls.lower[at] = bounds.lower(k)[i];
        controls.upper[at] = bounds.upper(k)[i];
        const bool pushed = slope > 0 ? u == controls.lower[at] : u == controls.upper[at];
        controls.base[at] = u - (pushed ? slope / controls.penalty[at] : 0);
        multipliers += pushed;
      }
  }
  /// The point: its control steps rolled out through the model.
  Eigen::VectorXd point() {
    Feedback written = feedback;
    descent.write(written);
    LinearRollout at(problem, bounds);
    at.run(linearization, trajectory, gaps, written, false);
    return dense->stack(at.z());
  }
  double value(const Eigen::VectorXd& z) const {
    return 0.5 * z.dot(dense->H * z) + dense->g.dot(z) + rows.value(z) + controls.value(z);
  }
  Eigen::VectorXd gradient(const Eigen::VectorXd& z) const {
    return dense->H * z + dense->g + rows.gradient(z) + controls.gradient(z);
  }

  LinearQuadratic lq;
  ShootingProblem problem;
  ControlBounds bounds;
  Linearization linearization;
  Gaps gaps;
  Trajectory trajectory;
  Adjoint adjoint;
  BackwardSweep sweep;
  std::unique_ptr<StageSolver> stages;
  Feedback feedback;
  LinearRollout rollout;
  Augmentation augmentation;
  HorizonConstraints constraints;
  HorizonDescent descent;
  std::optional<DenseHorizon> dense;  ///< without penalties
  std::optional<DenseHorizon> own;    ///< with row penalties at the iterate
  DensePenalty rows, controls;
  int multipliers = 0;
};

TEST(HorizonDescent, FallsToTheMinimumOfThePenalizedModel) {
  int rows_outside = 0, controls_outside = 0, short_steps = 0, multipliers = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Descent at(seed);
    multipliers += at.multipliers;
    Eigen::VectorXd z = at.point();
    EXPECT_LT((at.dense->E * z - at.dense->e).norm(), 1e-10);
    bool done = false;
    for (int i = 0; i < 30 && !done; ++i) {
      ASSERT_EQ(at.run_sweep(), -1);
      at.rollout.run(at.linearization, at.trajectory, at.gaps, at.feedback, false);
      const Eigen::VectorXd way = at.dense->stack(at.rollout.z()) - z;
      done = at.descent.advance(at.rollout, at.constraints, at.linearization);
      const Eigen::VectorXd next = at.point();
      EXPECT_LE(at.value(next), at.value(z) + 1e-12 * std::abs(at.value(z)));
      // An exact line search: either the slope along the step vanishes, or the whole step is taken.
      const double slope = at.gradient(z).dot(way), left = at.gradient(next).dot(way);
      const double share = (next - z).norm() / way.norm();
      const bool whole = way.norm() < 1e-9 || share > 1 - 1e-9;
      EXPECT_LE(left, 1.01e-3 * std::abs(slope) + 1e-10) << i;
      EXPECT_TRUE(whole || left >= -1.01e-3 * std::abs(slope) - 1e-10) << i;
      short_steps += !whole;
      z = next;
    }
    EXPECT_TRUE(done);
    EXPECT_LT((at.dense->S.transpose() * at.gradient(z)).lpNorm<Eigen::Infinity>(), 1e-7);
    rows_outside += static_cast<int>((at.rows.outside(z).array() != 0).count());

    at.descent.leave(at.stages->active_set(), at.linearization);
    const Eigen::VectorXd outside = at.controls.outside(z);
    ASSERT_EQ(
        at.sweep.run(at.linearization, at.trajectory, at.gaps, {}, *at.stages, at.feedback, true),
        -1);
    for (int k = 0, i = 0; k < at.problem.knots(); ++k)
      for (int j = 0; j < at.problem.nu(k); ++j, ++i) {
        EXPECT_EQ(at.stages->active_set().holds(k, j), outside[i] != 0) << k << ' ' << j;
        if (outside[i] == 0) continue;
        ++controls_outside;
        const double bound = (outside[i] < 0 ? at.controls.lower : at.controls.upper)[i];
        EXPECT_EQ(at.feedback.k[k][j], bound - at.trajectory.u(k)[j]) << k << ' ' << j;
      }
    // After leave(), the model has the rows at the point; after restore(), those at the iterate.
    const DenseHorizon left(at.linearization, true);
    const Eigen::VectorXd of_rows = at.dense->H * z + at.dense->g + at.rows.gradient(z);
    EXPECT_LT((left.H * z + left.g - of_rows).lpNorm<Eigen::Infinity>(), 1e-8);
    EXPECT_TRUE(at.constraints.restore(at.linearization));
    const DenseHorizon restored(at.linearization, true);
    EXPECT_EQ(restored.H, at.own->H);
    EXPECT_EQ(restored.g, at.own->g);
  }
  EXPECT_GT(rows_outside, 50);
  EXPECT_GT(controls_outside, 50);
  EXPECT_GT(short_steps, 10);
  EXPECT_GT(multipliers, 50);
}

TEST(HorizonDescent, RecognizesMinimumAtTheStart) {
  Descent at(3);
  for (int i = 0; i < 30; ++i) {
    ASSERT_EQ(at.run_sweep(), -1);
    at.rollout.run(at.linearization, at.trajectory, at.gaps, at.feedback, false);
    if (at.descent.advance(at.rollout, at.constraints, at.linearization)) break;
  }
  const Eigen::VectorXd z = at.point();
  ASSERT_EQ(at.run_sweep(), -1);
  at.rollout.run(at.linearization, at.trajectory, at.gaps, at.feedback, false);
  EXPECT_LT((at.dense->stack(at.rollout.z()) - z).norm(), 1e-8);
  EXPECT_TRUE(at.descent.advance(at.rollout, at.constraints, at.linearization));
  EXPECT_LT((at.point() - z).norm(), 1e-8);
}

}  // namespace
}  // namespace conddp::testing
