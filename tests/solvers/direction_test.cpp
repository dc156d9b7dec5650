// Directions, compared with the dense optimum of the whole horizon's linear-quadratic model.
#include "solvers/globalization/direction.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/dense_horizon.hpp"
#include "support/linear_quadratic.hpp"
#include "support/small_qp.hpp"

namespace conddp::testing {
namespace {

/// A problem structure with a random linear-quadratic model and a direction.
struct RandomModel {
  RandomModel(const ShootingProblem& shape, unsigned seed, const Direction::Recipe& recipe,
              bool with_gaps = true)
      : problem(shape),
        bounds(problem),
        linearization(problem),
        gaps(problem),
        trajectory(random_guess(problem, seed)),
        adjoint(problem, bounds),
        direction(problem, bounds, recipe),
        open(with_gaps) {
    RandomNumbers random(seed);
    randomize(problem, random, linearization);
    bounds.clamp(trajectory);
    gaps.set(linearization, open);
  }
  int find(const Augmentation* augmentation = nullptr, double regularization = 0) {
    return direction.find(linearization, trajectory, gaps, adjoint, regularization, augmentation);
  }
  DenseHorizon dense() const { return {linearization, open}; }
  Eigen::VectorXd step() const { return dense().stack(direction.step().z()); }

  const ShootingProblem& problem;
  ControlBounds bounds;
  Linearization linearization;
  Gaps gaps;
  Trajectory trajectory;
  Adjoint adjoint;
  Direction direction;
  bool open;
};

/// Problems with dense dynamics and with semi-implicit Euler, with different numbers of controls.
std::vector<ShootingProblem> shapes() {
  std::vector<ShootingProblem> problems;
  problems.push_back(std::move(*LinearQuadratic(1, 2, {1}, 4, -kFree, kFree).problem));
  problems.push_back(std::move(*LinearQuadratic(1, 3, {1, 2}, 3, -kFree, kFree).problem));
  problems.push_back(std::move(*LinearQuadratic(1, 4, {3, 2}, 2, -kFree, kFree).problem));
  problems.push_back(tracking_problem(double_integrator(2), Integrator::semi_implicit_euler, 5, 0.3,
                                      {0, 0, 0, 0}, {{0, 0, 0, 0}, {1}, {1}, {1}}));
  return problems;
}

double largest(const Eigen::VectorXd& v) { return v.lpNorm<Eigen::Infinity>(); }

TEST(Direction, StepSolvesTheKktSystemOfTheHorizon) {
  for (const ShootingProblem& problem : shapes())
    for (const unsigned seed : {1u, 2u, 3u})
      for (const bool open : {false, true}) {
        SCOPED_TRACE(fmt::format("{} states, seed {}, gaps {}", problem.nx(), seed, open));
        RandomModel model(problem, seed, {}, open);
        ASSERT_EQ(model.find(), -1);
        const DenseHorizon dense = model.dense();
        const Eigen::VectorXd z = dense.minimum().z;
        EXPECT_LT(largest(model.step() - z), 1e-10);
        EXPECT_NEAR(model.direction.step().slope(), dense.g.dot(z), 1e-10);
        EXPECT_NEAR(model.direction.curvature(model.linearization), z.dot(dense.H * z), 1e-10);
        EXPECT_TRUE(model.direction.qp().within_bounds());
        EXPECT_EQ(model.direction.qp().sweeps(), 1);
      }
}

TEST(Direction, RegularizationActsAsADenseCost) {
  for (const ShootingProblem& problem : shapes()) {
    RandomModel model(problem, 4, {});
    ASSERT_EQ(model.find(nullptr, 0.7), -1);
    DenseHorizon dense = model.dense();
    dense.H.diagonal().array() += 0.7;
    EXPECT_LT(largest(model.step() - dense.minimum().z), 1e-10);
  }
}

/// Bounds on δu of all controls.
void control_steps(const RandomModel& model, Eigen::VectorXd& lower, Eigen::VectorXd& upper) {
  lower.resize(model.bounds.size());
  upper.resize(model.bounds.size());
  for (int k = 0; k < model.problem.knots(); ++k) {
    const int at = model.bounds.offset(k), nu = model.problem.nu(k);
    lower.segment(at, nu) = model.bounds.lower(k) - model.trajectory.u(k);
    upper.segment(at, nu) = model.bounds.upper(k) - model.trajectory.u(k);
  }
}

TEST(Direction, BoundedControlsSolveTheQuadraticProgram) {
  int held = 0, free = 0, settled = 0, all = 0;
  for (const auto& nu : {std::vector<int>{1, 2}, std::vector<int>{3}})
    for (unsigned seed = 1; seed <= 12; ++seed) {
      SCOPED_TRACE(fmt::format("{} controls, seed {}", nu[0], seed));
      const LinearQuadratic lq(1, 2 + seed % 3, nu, 2, -0.4, 0.3);
      RandomModel model(*lq.problem, seed, {.clamp_controls = true, .box_stage = true},
                        seed % 2 == 0);
      ASSERT_EQ(model.find(), -1);
      ++all;
      if (!model.direction.qp().within_bounds()) continue;
      ++settled;
      const DenseHorizon dense = model.dense();
      const int n = model.bounds.size();
      SmallQp qp{.H = dense.S.transpose() * dense.H * dense.S,
                 .g = dense.S.transpose() * (dense.H * dense.s + dense.g),
                 .A = Eigen::MatrixXd::Identity(n, n)};
      control_steps(model, qp.lower, qp.upper);
      const SmallQpOptimum optimum = enumerate_active_sets(qp);
      EXPECT_LT(largest(model.step() - dense.S * optimum.x - dense.s), 1e-10);
      for (int k = 0; k < model.problem.knots(); ++k)
        for (int i = 0; i < model.problem.nu(k); ++i) {
          const bool at_bound = optimum.multipliers[model.bounds.offset(k) + i] != 0;
          EXPECT_EQ(model.direction.qp().active_set().holds(k, i), at_bound) << k << ' ' << i;
          (at_bound ? held : free)++;
          if (!at_bound) continue;
          EXPECT_EQ(model.direction.feedback().K[k].row(i).norm(), 0) << k << ' ' << i;
        }
    }
  EXPECT_EQ(settled, all);
  EXPECT_GT(held, 30);
  EXPECT_GT(free, 30);
}

// Augmented Lagrangian rows are active according to the step, not the iterate.
TEST(Direction, AugmentationMinimizesPenaltiesAlongTheHorizon) {
  int held = 0, outside = 0, changed_sides = 0, unsettled = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const LinearQuadratic lq(1, 2 + seed % 3, {1, 2}, 3, -0.6, 0.6);
    const ShootingProblem problem = rows_at_all_nodes(lq, 3, -0.5, 0.5);
    RandomModel model(problem, seed, {.clamp_controls = true, .box_stage = true});
    Augmentation augmentation(problem);
    RandomNumbers random(100 + seed);
    for (double& weight : augmentation.penalty) weight = random.uniform(1, 1000);
    for (double& shift : augmentation.shift) shift = random.uniform(-0.5, 0.5);

    // The minimized function, and the same function at the iterate.
    const DenseHorizon dense = model.dense();
    const DensePenalty penalty = penalty_of_rows(problem, model.linearization, augmentation);
    const Eigen::VectorXd here = penalty.outside(Eigen::VectorXd::Zero(dense.size()));
    penalty.add_to(model.linearization);
    const DenseHorizon before = model.dense();
    model.adjoint.compute(model.linearization, model.trajectory, model.gaps, Feedback(problem));
    model.direction.qp().trust_model();
    ASSERT_EQ(model.find(&augmentation), -1);
    EXPECT_EQ(model.dense().g, before.g) << "the model comes back as it was";
    EXPECT_EQ(model.dense().H, before.H);

    unsettled += model.direction.qp().unsettled();
    ASSERT_TRUE(model.direction.qp().within_bounds());
    const Eigen::VectorXd z = model.step();
    EXPECT_LT(largest(dense.E * z - dense.e), 1e-10);
    EXPECT_NEAR(model.direction.step().slope(), before.g.dot(z), 1e-9);
    const Eigen::VectorXd there = penalty.outside(z);
    outside += static_cast<int>((there.array() != 0).count());
    changed_sides += static_cast<int>(((there.array() != 0) != (here.array() != 0)).count());
    // The derivative with respect to each control vanishes or pushes it against its bound.
    const Eigen::VectorXd slope =
        dense.S.transpose() * (dense.H * z + dense.g + penalty.gradient(z));
    Eigen::VectorXd lower, upper;
    control_steps(model, lower, upper);
    for (int k = 0, at = 0; k < problem.knots(); ++k)
      for (int i = 0; i < problem.nu(k); ++i, ++at) {
        const double du = model.direction.step().du(k)[i];
        const bool at_lower = std::abs(du - lower[at]) < 1e-12,
                   at_upper = std::abs(du - upper[at]) < 1e-12;
        EXPECT_GE(du, lower[at] - 1e-12);
        EXPECT_LE(du, upper[at] + 1e-12);
        EXPECT_LT(at_lower ? 0 : slope[at], 1e-8) << at;
        EXPECT_GT(at_upper ? 0 : slope[at], -1e-8) << at;
        held += at_lower || at_upper;
      }
  }
  EXPECT_GT(held, 30);
  EXPECT_GT(outside, 30);
  EXPECT_GT(changed_sides, 30);
  EXPECT_GT(unsettled, 3) << "where sets alternate the descent finds the minimum";
}

TEST(Direction, NullSpaceSatisfiesEquationsWithDenseMultipliers) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    // Three states and six controls of two knots each: one row per knot and one at the end.
    const LinearQuadratic lq(1, 2 + seed % 3, {3, 2}, 3, -kFree, kFree);
    const ShootingProblem problem = rows_at_all_nodes(lq, 1, 0.25, 0.25);
    RandomModel model(problem, seed, {.null_space = true}, seed % 2 == 0);
    ASSERT_EQ(model.find(), -1);
    const DenseHorizon::Optimum optimum =
        model.dense().minimum(dense_constraints(problem, model.linearization),
                              model.linearization.constraint -
                                  Eigen::VectorXd::Constant(problem.constraint_rows(), 0.25));
    EXPECT_LT(largest(model.step() - optimum.z), 1e-9);
    EXPECT_LT(largest(model.direction.null_space()->find_multipliers(model.direction.step()) -
                      optimum.multipliers),
              1e-8);
    EXPECT_LT(model.direction.null_space()->contradiction(), 1e-12);
  }
}

}  // namespace
}  // namespace conddp::testing
