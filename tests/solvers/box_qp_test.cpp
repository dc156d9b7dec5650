#include "solvers/stages/box_qp.hpp"

#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "support/small_qp.hpp"

namespace conddp {
namespace {

using testing::enumerate_active_sets;
using testing::SmallQp;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

SmallQp random_qp(int n, std::mt19937& engine, double tightness) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const auto draw = [&] { return normal(engine); };
  const Eigen::MatrixXd B = Eigen::MatrixXd::NullaryExpr(n, n, draw);
  SmallQp qp;
  qp.H = B * B.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
  qp.g = Eigen::VectorXd::NullaryExpr(n, draw);
  qp.A = Eigen::MatrixXd::Identity(n, n);
  qp.lower.resize(n);
  qp.upper.resize(n);
  for (int i = 0; i < n; ++i) {
    qp.lower[i] = -tightness * uniform(engine);
    qp.upper[i] = tightness * uniform(engine);
    if (uniform(engine) < 0.15) qp.lower[i] = -kInfinity;
    if (uniform(engine) < 0.15) qp.upper[i] = kInfinity;
    if (uniform(engine) < 0.1) qp.upper[i] = qp.lower[i] = 0.2;
  }
  return qp;
}

TEST(BoxQp, EqualsEnumerationOfActiveSets) {
  std::mt19937 engine(1);
  BoxQp solver(6);
  for (int trial = 0; trial < 600; ++trial) {
    const int n = 1 + trial % 6;
    const SmallQp qp = random_qp(n, engine, trial % 3 == 0 ? 0.1 : 1);
    std::vector<BoundState> active(n, BoundState::free);
    ASSERT_EQ(solver.solve(qp.H, qp.g, qp.lower, qp.upper, active), BoxQp::Status::solved);
    const Eigen::VectorXd expected = enumerate_active_sets(qp).x;
    EXPECT_LE((solver.x() - expected).lpNorm<Eigen::Infinity>(), 1e-10) << "trial " << trial;
    for (int i = 0; i < n; ++i) {
      EXPECT_GE(solver.x()[i], qp.lower[i]);
      EXPECT_LE(solver.x()[i], qp.upper[i]);
      if (active[i] == BoundState::free) continue;
      EXPECT_EQ(solver.x()[i], active[i] == BoundState::at_lower ? qp.lower[i] : qp.upper[i]);
    }
  }
}

TEST(BoxQp, FactorCoversFreeBlockOfTheSolution) {
  std::mt19937 engine(2);
  BoxQp solver(6);
  for (int trial = 0; trial < 100; ++trial) {
    const SmallQp qp = random_qp(6, engine, 0.5);
    std::vector<BoundState> active(6, BoundState::free);
    ASSERT_EQ(solver.solve(qp.H, qp.g, qp.lower, qp.upper, active), BoxQp::Status::solved);
    const auto free = solver.free();
    const Eigen::MatrixXd L = solver.free_factor().view().triangularView<Eigen::Lower>();
    const Eigen::MatrixXd product = L * L.transpose();
    for (std::size_t a = 0; a < free.size(); ++a) {
      for (std::size_t b = 0; b < free.size(); ++b) {
        EXPECT_NEAR(product(a, b), qp.H(free[a], free[b]), 1e-12);
      }
    }
  }
}

TEST(BoxQp, SolutionIsIndependentOfTheStart) {
  std::mt19937 engine(3);
  BoxQp solver(6);
  std::uniform_int_distribution<int> state(-1, 1);
  for (int trial = 0; trial < 100; ++trial) {
    const SmallQp qp = random_qp(6, engine, 0.3);
    std::vector<BoundState> active(6, BoundState::free);
    ASSERT_EQ(solver.solve(qp.H, qp.g, qp.lower, qp.upper, active), BoxQp::Status::solved);
    const Eigen::VectorXd x = solver.x();
    const std::vector<BoundState> solution = active;
    ASSERT_EQ(solver.solve(qp.H, qp.g, qp.lower, qp.upper, active), BoxQp::Status::solved);
    EXPECT_LE(solver.iterations(), 1) << "trial " << trial;
    EXPECT_LE((solver.x() - x).lpNorm<Eigen::Infinity>(), 1e-12);
    EXPECT_EQ(active, solution);
    for (BoundState& s : active) s = static_cast<BoundState>(state(engine));
    ASSERT_EQ(solver.solve(qp.H, qp.g, qp.lower, qp.upper, active), BoxQp::Status::solved);
    EXPECT_LE((solver.x() - x).lpNorm<Eigen::Infinity>(), 1e-10);
  }
}

// A full projected Newton step from 0 raises the objective here. An Armijo test with the wrong sign
// of the free gradient would accept it.
TEST(BoxQp, RejectsAProjectedStepThatRaisesTheObjective) {
  SmallQp qp;
  qp.H = (Eigen::Matrix2d() << 1, -0.99, -0.99, 1).finished();
  qp.g = Eigen::Vector2d(-0.1, -0.1);
  qp.A = Eigen::Matrix2d::Identity();
  qp.lower = Eigen::Vector2d(-10, -0.02);
  qp.upper = Eigen::Vector2d(10, 0.02);
  const Eigen::Vector2d newton = -qp.H.ldlt().solve(qp.g);
  const Eigen::Vector2d projected = newton.cwiseMax(qp.lower).cwiseMin(qp.upper);
  ASSERT_GT(qp.value(projected), 1);
  const Eigen::VectorXd expected = enumerate_active_sets(qp).x;
  BoxQp solver(2);
  std::vector<BoundState> active(2, BoundState::free);
  ASSERT_EQ(solver.solve(qp.H, qp.g, qp.lower, qp.upper, active), BoxQp::Status::solved);
  EXPECT_LE((solver.x() - expected).norm(), 1e-12);
  EXPECT_LT(qp.value(solver.x()), 0);
}

/// Q_uu with a stiff cost-to-go is nearly of rank one.
TEST(BoxQp, StronglyCoupledEntriesMeetTheirBounds) {
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(engine); };
  BoxQp solver(5);
  for (int trial = 0; trial < 400; ++trial) {
    const int n = 2 + trial % 4;
    SmallQp qp = random_qp(n, engine, 1);
    const Eigen::VectorXd stiff = Eigen::VectorXd::NullaryExpr(n, draw);
    qp.H += 1e4 * stiff * stiff.transpose();
    qp.g += 1e4 * normal(engine) * stiff;
    std::vector<BoundState> active(n, BoundState::free);
    ASSERT_EQ(solver.solve(qp.H, qp.g, qp.lower, qp.upper, active), BoxQp::Status::solved);
    const Eigen::VectorXd expected = enumerate_active_sets(qp).x;
    EXPECT_LE((solver.x() - expected).lpNorm<Eigen::Infinity>(), 1e-8) << "trial " << trial;
  }
}

TEST(BoxQp, PositiveGradientAtTheLowerBoundIsOptimal) {
  BoxQp solver(1);
  const Eigen::MatrixXd H = Eigen::MatrixXd::Identity(1, 1);
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  std::vector<BoundState> active(1, BoundState::at_lower);
  ASSERT_EQ(solver.solve(H, one, Eigen::VectorXd::Zero(1), one, active), BoxQp::Status::solved);
  EXPECT_EQ(solver.x()[0], 0);
  EXPECT_EQ(active[0], BoundState::at_lower);
  EXPECT_TRUE(solver.free().empty());
  active[0] = BoundState::at_upper;
  ASSERT_EQ(solver.solve(H, -2 * one, Eigen::VectorXd::Zero(1), one, active),
            BoxQp::Status::solved);
  EXPECT_EQ(solver.x()[0], 1);
  EXPECT_EQ(active[0], BoundState::at_upper);
}

TEST(BoxQp, FailsOnlyIfTheFreeBlockIsIndefinite) {
  BoxQp solver(2);
  const Eigen::MatrixXd H = Eigen::Vector2d(1, -1).asDiagonal();
  const Eigen::VectorXd lower = Eigen::Vector2d(-1, -1), upper = Eigen::Vector2d(1, 1);
  std::vector<BoundState> active = {BoundState::free, BoundState::free};
  EXPECT_EQ(solver.solve(H, Eigen::Vector2d(1, 0), lower, upper, active),
            BoxQp::Status::not_positive_definite);
  active = {BoundState::free, BoundState::at_upper};
  EXPECT_EQ(solver.solve(H, Eigen::Vector2d(0.5, -3), lower, upper, active), BoxQp::Status::solved);
  EXPECT_EQ(solver.x()[0], -0.5);
  EXPECT_EQ(solver.x()[1], 1);
}

TEST(BoxQp, SolvesDegenerateZeroMultipliers) {
  // The unconstrained optimum lies exactly on the bounds.
  const Eigen::MatrixXd H = (Eigen::Matrix2d() << 2, 1, 1, 3).finished();
  const Eigen::Vector2d optimum(1, -1);
  const Eigen::VectorXd g = -H * optimum;
  BoxQp solver(2);
  for (int start = 0; start < 9; ++start) {
    std::vector<BoundState> active = {static_cast<BoundState>(start % 3 - 1),
                                      static_cast<BoundState>(start / 3 - 1)};
    ASSERT_EQ(solver.solve(H, g, Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1), active),
              BoxQp::Status::solved);
    EXPECT_LE((solver.x() - optimum).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace conddp
