#include "solvers/ipopt/hessian_alternation.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

/// An iterate of a full step with this error.
InteriorPointIterate good(double error) {
  return {.dual_infeasibility = error, .barrier = 0.1, .trials = 1};
}

InteriorPointIterate regularized(double error) {
  InteriorPointIterate iterate = good(error);
  iterate.regularization = 1e-4;
  return iterate;
}

InteriorPointIterate cut(double error) {
  InteriorPointIterate iterate = good(error);
  iterate.trials = 5;
  return iterate;
}

/// Poor steps until Gauss-Newton Hessians are abandoned.
int poor_steps_to_exact(HessianAlternation& alternation) {
  int steps = 0;
  for (; steps < 100 && alternation.gauss_newton(); ++steps) alternation.watch(cut(1));
  return steps;
}

TEST(HessianAlternation, KeepsGaussNewtonWhileFullStepsReduceError) {
  HessianAlternation alternation;
  double error = 1;
  alternation.begin(good(error));
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(alternation.gauss_newton()) << i;
    alternation.watch(good(error *= 0.5));
  }
}

TEST(HessianAlternation, ShortStepsOrGrowingErrorsUseExactHessians) {
  HessianAlternation alternation;
  alternation.begin(good(1));
  EXPECT_EQ(poor_steps_to_exact(alternation), 2);
  alternation.begin(good(1));
  alternation.watch(good(3));
  EXPECT_TRUE(alternation.gauss_newton());
  alternation.watch(good(10));
  EXPECT_FALSE(alternation.gauss_newton());
}

TEST(HessianAlternation, UsesExactHessiansOnSlowBarrierProblems) {
  HessianAlternation alternation;
  double error = 1;
  alternation.begin(good(error));
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(alternation.gauss_newton()) << i;
    alternation.watch(good(error *= 0.8));
  }
  EXPECT_FALSE(alternation.gauss_newton());
}

TEST(HessianAlternation, NewBarrierRestartsTheJudgement) {
  HessianAlternation alternation;
  alternation.begin(good(1));
  double error = 1;
  for (int i = 0; i < 20; ++i) {
    InteriorPointIterate iterate = good(error *= 0.9);
    iterate.barrier = i % 3 == 0 ? 0.1 : 0.2;
    alternation.watch(iterate);
    EXPECT_TRUE(alternation.gauss_newton()) << i;
  }
}

TEST(HessianAlternation, KeepsExactHessiansThatNeedNoRegularization) {
  HessianAlternation alternation;
  alternation.begin(good(1));
  poor_steps_to_exact(alternation);
  for (int i = 0; i < 100; ++i) alternation.watch(cut(i));
  EXPECT_FALSE(alternation.gauss_newton());
}

TEST(HessianAlternation, DoublesItsPatienceWithEveryReturn) {
  HessianAlternation alternation;
  alternation.begin(good(1));
  for (const int patience : {1, 2, 4, 8}) {
    EXPECT_EQ(poor_steps_to_exact(alternation), 2 * patience);
    int steps = 0;
    for (; !alternation.gauss_newton(); ++steps) alternation.watch(regularized(1));
    EXPECT_EQ(steps, patience);
  }
}

TEST(HessianAlternation, IgnoresTheRestorationPhase) {
  HessianAlternation alternation;
  alternation.begin(good(1));
  InteriorPointIterate iterate = cut(1000);
  iterate.restoration = true;
  for (int i = 0; i < 100; ++i) alternation.watch(iterate);
  EXPECT_TRUE(alternation.gauss_newton());
}

}  // namespace
}  // namespace conddp
