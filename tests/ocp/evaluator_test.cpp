// Rollouts along a policy, evaluations of long horizons, and their checkpoints, compared with a
// manual recursion.
#include "ocp/evaluation/evaluator.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "ocp/evaluation/checkpoint.hpp"
#include "support/constrained_problems.hpp"
#include "support/random_numbers.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// Three knots with two controls and two knots with one, in three states, all linear; the second
/// state is bounded at nodes 1 to 5.
struct TwoPhases {
  TwoPhases() : problem(make()) {}

  ShootingProblem make() const {
    const testing::TrackingCost first{
        .goal = {0.1, -0.2, 0.3}, .q = {1, 2, 3}, .r = {0.5, 0.25}, .qf = {4, 5, 6}};
    const testing::TrackingCost second{
        .goal = {0.1, -0.2, 0.3}, .q = {3, 1, 2}, .r = {0.75}, .qf = {4, 5, 6}};
    const auto of = [&](const Eigen::MatrixXd& B) { return linear_system(A, B, c); };
    const auto wide = of(B_wide);
    const ShootingProblem free(
        {0.5, -0.4, 0.3},
        {testing::tracking_phase(wide, Integrator::discrete, 3, 0.1, first, -0.3, 0.4),
         testing::tracking_phase(of(B_narrow), Integrator::discrete, 2, 0.2, second, -0.2, 0.1)},
        testing::terminal_phase(wide, first));
    return testing::with_constraints(free, {{.name = "band",
                                             .residual = coordinate_residual(free.manifold(), {1}),
                                             .reference = {0.1},
                                             .lower = {-0.2},
                                             .upper = {0.3},
                                             .first = 1,
                                             .last = 5}});
  }

  Eigen::MatrixXd A{{0.9, -0.2, 0.1}, {0.3, 1.1, 0}, {0.2, -0.4, 0.7}};
  Eigen::MatrixXd B_wide{{0.1, 0.4}, {0.2, -0.3}, {0.5, 0.2}};
  Eigen::MatrixXd B_narrow{{0.3}, {-0.1}, {0.2}};
  Eigen::VectorXd c{{0.01, -0.02, 0.03}};
  ShootingProblem problem;
};

/// A trajectory that violates the dynamics, a policy about it, and the constraint's augmentation.
struct PolicyCase {
  explicit PolicyCase(const ShootingProblem& problem)
      : reference(testing::random_guess(problem, 3, 0.5)),
        gap(problem.ndx(), problem.knots()),
        policy(problem),
        augmentation(problem) {
    RandomNumbers random(4);
    for (double& g : gap.reshaped()) g = random.uniform(-0.3, 0.3);
    for (int k = 0; k < problem.knots(); ++k) {
      for (double& entry : policy.k[k]) entry = random.uniform(-0.4, 0.4);
      for (double& entry : policy.K[k].reshaped()) entry = random.uniform(-0.4, 0.4);
    }
    // Disabled rows have no augmentation.
    for (auto* part : {&augmentation.penalty, &augmentation.shift, &augmentation.multiplier})
      for (const NodeConstraint& c : problem.constraints())
        (*part)[c.row] = random.uniform(0.2, 0.9);
  }

  Trajectory reference;
  Eigen::MatrixXd gap;
  Feedback policy;
  Augmentation augmentation;
};

struct HandRollout {
  Trajectory trajectory;
  double cost = 0;
};

/// ½ (x − goal)ᵀ diag(q) (x − goal).
double distance_cost(const Eigen::VectorXd& x, const Eigen::Vector3d& q) {
  return 0.5 * q.dot((x - Eigen::Vector3d(0.1, -0.2, 0.3)).cwiseAbs2());
}

/// ½ ρ dist²(g + shift) + ν g of the band.
double augmentation_of(double x, const Augmentation& a, int row) {
  const double g = x - 0.1, shifted = g + a.shift[row];
  const double off = shifted - std::clamp(shifted, -0.2, 0.3);
  return 0.5 * a.penalty[row] * off * off + a.multiplier[row] * g;
}

HandRollout by_hand(const TwoPhases& of, const PolicyCase& at, double alpha,
                    const RolloutOptions& options) {
  HandRollout out{of.problem.create_trajectory()};
  for (int k = 0; k <= 5; ++k) {
    const Eigen::VectorXd x = out.trajectory.x(k);
    if (k > 0 && options.augmentation != nullptr) {
      out.cost += augmentation_of(x[1], at.augmentation, of.problem.constraint_offset(k));
    }
    if (k == 5) {
      out.cost += distance_cost(x, {4, 5, 6});
      break;
    }
    const bool first = k < 3;
    Eigen::VectorXd u =
        at.reference.u(k) + alpha * at.policy.k[k] + at.policy.K[k] * (x - at.reference.x(k));
    if (options.clamp_controls) u = u.cwiseMax(first ? -0.3 : -0.2).cwiseMin(first ? 0.4 : 0.1);
    out.trajectory.u(k) = u;
    const Eigen::VectorXd r =
        first ? Eigen::VectorXd(Eigen::Vector2d(0.5, 0.25)) : Eigen::VectorXd::Constant(1, 0.75);
    out.cost += (first ? 0.1 : 0.2) *
                (distance_cost(x, first ? Eigen::Vector3d(1, 2, 3) : Eigen::Vector3d(3, 1, 2)) +
                 0.5 * r.dot(u.cwiseAbs2()));
    Eigen::VectorXd next = of.A * x + (first ? of.B_wide : of.B_narrow) * u + of.c;
    if (options.contract_gaps) next += (alpha - 1) * at.gap.col(k);
    out.trajectory.x(k + 1) = next;
  }
  return out;
}

void expect_equal(const Trajectory& a, const Trajectory& b) {
  for (int k = 0; k <= a.knots(); ++k) {
    EXPECT_LT((a.x(k) - b.x(k)).norm(), 1e-13) << k;
    if (k < a.knots()) {
      EXPECT_LT((a.u(k) - b.u(k)).norm(), 1e-13) << k;
    }
  }
}

TEST(Rollout, FollowsPolicyGapsAndBoundsInEveryLane) {
  const TwoPhases of;
  const PolicyCase at(of.problem);
  Evaluator evaluator(of.problem);
  double steps[kLaneWidth];
  for (int l = 0; l < kLaneWidth; ++l) steps[l] = 1.0 / (1 + l);
  LaneRollout lanes(of.problem);
  SingleRollout alone(of.problem);
  Trajectory extracted = of.problem.create_trajectory();
  for (const bool contract : {false, true})
    for (const bool clamp : {false, true})
      for (const bool augment : {false, true}) {
        const RolloutOptions options{.contract_gaps = contract,
                                     .clamp_controls = clamp,
                                     .augmentation = augment ? &at.augmentation : nullptr};
        evaluator.roll_out(at.reference, at.gap, at.policy, steps, options, lanes);
        for (int l = 0; l < kLaneWidth; ++l) {
          const HandRollout expected = by_hand(of, at, steps[l], options);
          lanes.extract(l, extracted);
          expect_equal(extracted, expected.trajectory);
          EXPECT_NEAR(lanes.cost[l], expected.cost, 1e-13);
          evaluator.roll_out(at.reference, at.gap, at.policy, steps[l], options, alone);
          expect_equal(alone.trajectory, expected.trajectory);
          EXPECT_NEAR(alone.cost, expected.cost, 1e-13);
          EXPECT_EQ(alone.first_bad_knot, -1);
        }
      }
}

TEST(Evaluator, SimulatesControlsFromTheInitialState) {
  const TwoPhases of;
  PolicyCase at(of.problem);
  at.policy = Feedback(of.problem);
  for (const bool clamp : {false, true}) {
    Trajectory moved = at.reference;
    EXPECT_EQ(Evaluator(of.problem).simulate(moved, clamp), -1);
    expect_equal(moved, by_hand(of, at, 0, {.clamp_controls = clamp}).trajectory);
  }
  Trajectory wild = at.reference;
  wild.u(3)[0] = std::nan("");
  EXPECT_EQ(Evaluator(of.problem).simulate(wild), 3);
}

TEST(Evaluator, ReturnsGapsCostsAndConstraintsForAnyThreads) {
  const TwoPhases of;
  const PolicyCase at(of.problem);
  const Trajectory& t = at.reference;
  for (const int threads : {1, 3}) {
    Evaluator evaluator(of.problem, threads);
    Evaluation found(of.problem);
    Linearization linear(of.problem);
    evaluator.evaluate(t, found, &at.augmentation);
    evaluator.differentiate(t, linear, &at.augmentation);
    EXPECT_LT((linear.gap - found.gap).norm(), 1e-14);
    EXPECT_LT((linear.cost - found.cost).norm(), 1e-14);
    EXPECT_LT((linear.augmentation - found.augmentation).norm(), 1e-14);
    EXPECT_LT((linear.constraint - found.constraint).norm(), 1e-14);
    for (int k = 0; k <= 5; ++k) {
      const bool first = k < 3;
      if (k > 0) {
        const int row = of.problem.constraint_offset(k);
        EXPECT_NEAR(found.constraint[row], t.x(k)[1] - 0.1, 1e-15);
        EXPECT_NEAR(found.augmentation[k], augmentation_of(t.x(k)[1], at.augmentation, row), 1e-15);
      } else {
        EXPECT_EQ(found.augmentation[0], 0);
      }
      if (k == 5) {
        EXPECT_NEAR(found.cost[5], distance_cost(t.x(5), {4, 5, 6}), 1e-14);
        break;
      }
      const Eigen::VectorXd next =
          of.A * t.x(k) + (first ? of.B_wide : of.B_narrow) * t.u(k) + of.c;
      EXPECT_LT((found.gap.col(k) - (next - t.x(k + 1))).norm(), 1e-14) << k;
    }
  }
}

// On a manifold, the derivative of the gradient alone is not symmetric.
TEST(Evaluator, ExactHessiansAreSymmetricAtEveryKnot) {
  const ShootingProblem problem = testing::quadrotor_move();
  RandomNumbers random(6);
  Trajectory t = problem.create_trajectory();
  std::vector<double> step(problem.ndx());
  for (int k = 0; k <= problem.knots(); ++k) {
    for (double& s : step) s = random.uniform(-1, 1);
    problem.manifold().integrate(t.x(k).data(), step.data(), t.x(k).data());
    if (k < problem.knots())
      for (double& u : t.u(k)) u = random.uniform(-1, 1);
  }
  Eigen::MatrixXd costates(problem.ndx(), problem.knots() + 1);
  for (double& c : costates.reshaped()) c = random.uniform(-1, 1);
  Evaluator evaluator(problem);
  evaluator.reserve_lagrangian_hessian(false);
  Linearization linear(problem);
  evaluator.differentiate(t, linear);
  evaluator.lagrangian_hessian(t, costates, linear);
  for (int k = 0; k <= problem.knots(); ++k) {
    const Eigen::MatrixXd& H = linear.knots[k].hessian();
    EXPECT_EQ(H, H.transpose()) << k;
    EXPECT_GT(H.norm(), 1e-3) << k;
  }
}

/// x⁺ = 0.5 x + u with cost ½ x² at every node.
ShootingProblem long_horizon(int knots) {
  const Eigen::MatrixXd half = Eigen::MatrixXd::Constant(1, 1, 0.5);
  return testing::tracking_problem(
      linear_system(half, Eigen::MatrixXd::Identity(1, 1), Eigen::VectorXd::Zero(1)),
      Integrator::discrete, knots, 1, {1}, {{0}, {1}, {0}, {1}});
}

/// Number of checkpoints that a call passes.
template <class Call>
int checkpoints_of(Call call) {
  int count = 0;
  const CheckpointScope scope([&] { ++count; });
  call();
  return count;
}

TEST(Checkpoints, ComeEveryThousandKnotsOrGroups) {
  constexpr int kKnots = 2 * kKnotsBetweenCheckpoints + 3;
  const ShootingProblem problem = long_horizon(kKnots);
  Evaluator evaluator(problem);
  Trajectory t = problem.create_trajectory();
  for (int k = 0; k < kKnots; ++k) t.u(k)[0] = std::sin(k);
  EXPECT_EQ(checkpoints_of([&] { EXPECT_EQ(evaluator.simulate(t), -1); }), 2);
  const double steps[kLaneWidth] = {};
  LaneRollout rollout(problem);
  EXPECT_EQ(checkpoints_of([&] {
              evaluator.roll_out(t, Eigen::MatrixXd(), Feedback(problem), steps, {}, rollout);
            }),
            2);
  Evaluation values(problem);
  EXPECT_EQ(checkpoints_of([&] { evaluator.evaluate(t, values); }),
            kKnots / kLaneWidth / kKnotsBetweenCheckpoints);
  EXPECT_LT(values.gap.cwiseAbs().maxCoeff(), 1e-15);

  constexpr int kMany = kKnotsBetweenCheckpoints * kLaneWidth + 2 * kLaneWidth;
  const ShootingProblem longer = long_horizon(kMany);
  Trajectory wave = longer.create_trajectory();
  for (int k = 0; k < kMany; ++k) {
    wave.u(k)[0] = 2;
    wave.x(k)[0] = k;
  }
  wave.x(kMany)[0] = kMany;
  for (const int threads : {1, 2}) {
    Evaluator of_groups(longer, threads);
    Evaluation all(longer);
    EXPECT_EQ(checkpoints_of([&] { of_groups.evaluate(wave, all); }), 1) << threads;
    for (int k = 0; k < kMany; ++k) ASSERT_EQ(all.gap(0, k), 0.5 * k + 2 - (k + 1)) << k;
    for (int k = 0; k <= kMany; ++k) ASSERT_EQ(all.cost[k], 0.5 * k * k) << k;
  }
}

TEST(Checkpoints, InnermostScopeCountsAndMayAbandonTheLoop) {
  const ShootingProblem problem = long_horizon(kKnotsBetweenCheckpoints);
  Evaluator evaluator(problem);
  Trajectory t = problem.create_trajectory();
  int outer = 0, inner = 0;
  const auto simulate = [&] { evaluator.simulate(t); };
  {
    const CheckpointScope count([&] { ++outer; });
    simulate();
    {
      const CheckpointScope abandon([&] {
        ++inner;
        throw Abandoned();
      });
      EXPECT_THROW(simulate(), Abandoned);
    }
    EXPECT_EQ(inner, 1);
    simulate();
    EXPECT_EQ(outer, 2);
  }
  simulate();
  EXPECT_EQ(outer, 2);
  EXPECT_EQ(inner, 1);
}

}  // namespace
}  // namespace conddp
