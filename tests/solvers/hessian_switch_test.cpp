#include "solvers/iterate/hessian_switch.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/small_problems.hpp"

namespace conddp {
namespace {

constexpr double kTolerance = 1e-6;

/// A solve that watches its convergence; costs stand still.
struct Watched {
  Watched() : problem(testing::quadrotor_move()), evaluator(problem), linearization(problem) {
    choice.reset();
    choice.watch(row);
  }
  /// Iterations that multiply the stationarity by `factor` each, until the wanted set changes, at
  /// most `most` of them. Returns how many there were.
  int until_change(double factor, int most = 1000) {
    const bool before = choice.exact_wanted();
    for (int i = 1; i <= most; ++i) {
      ++row.iteration;
      row.stationarity *= factor;
      choice.watch(row);
      if (choice.exact_wanted() != before) return i;
    }
    return most;
  }
  ShootingProblem problem;
  Evaluator evaluator;
  Linearization linearization;
  HessianSwitch choice{HessianUse::when_slow, kTolerance, evaluator, linearization};
  IterationRecord row{.cost = 1, .stationarity = 1};
};

TEST(HessianSwitch, GaussNewtonStaysWhileItConverges) {
  Watched solve;
  EXPECT_EQ(solve.until_change(0.8, 60), 60);
}

TEST(HessianSwitch, EitherSetIsGivenUpWhereItCreepsAndGaussNewtonThenHasTwiceAsLong) {
  Watched solve;
  const int first = solve.until_change(1);
  EXPECT_TRUE(solve.choice.exact_wanted());
  const int exact = solve.until_change(1);
  EXPECT_FALSE(solve.choice.exact_wanted());
  EXPECT_EQ(solve.until_change(1), 2 * first);
  EXPECT_EQ(solve.until_change(1), exact);
  EXPECT_EQ(solve.until_change(1), 4 * first);
}

TEST(HessianSwitch, ExactHessiansStayWhereTheirRateLeadsToTheEnd) {
  Watched solve;
  const int window = [] {
    Watched other;
    other.until_change(1);
    return other.until_change(1);
  }();
  solve.until_change(1);
  // Four decades of six: two are left, and less than that was taken.
  EXPECT_EQ(solve.until_change(std::pow(10.0, -4.0 / window), window), window);
  EXPECT_TRUE(solve.choice.exact_wanted());
}

TEST(HessianSwitch, WhereRoundingAsksForExactHessiansTheyStay) {
  Watched solve;
  EXPECT_TRUE(solve.choice.turn());
  EXPECT_EQ(solve.until_change(1, 500), 500);
  EXPECT_FALSE(solve.choice.turn());
}

}  // namespace
}  // namespace conddp
