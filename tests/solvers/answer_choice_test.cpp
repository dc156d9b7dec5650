#include "solvers/constraints/answer_choice.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

constexpr SolverOptions::Tolerances kTolerances{
    .stationarity = 1e-6, .gap = 1e-9, .constraint = 1e-6, .complementarity = 1e-4};

KktNorms norms(double stationarity, double gap, double violation, double complementarity) {
  return {.stationarity = {stationarity, 0},
          .gap = {gap, 0},
          .violation = {violation, 0},
          .complementarity = complementarity};
}

double excess(const KktNorms& n) { return AnswerChoice::excess(n, kTolerances); }

TEST(AnswerChoice, MeasuresEveryNormByItsOwnTolerance) {
  EXPECT_DOUBLE_EQ(excess(norms(3e-6, 0, 0, 0)), 3);
  EXPECT_DOUBLE_EQ(excess(norms(0, 3e-9, 0, 0)), 3);
  EXPECT_DOUBLE_EQ(excess(norms(0, 0, 3e-6, 0)), 3);
  EXPECT_DOUBLE_EQ(excess(norms(0, 0, 0, 3e-4)), 3);
  EXPECT_DOUBLE_EQ(excess(norms(1e-6, 5e-9, 2e-6, 3e-4)), 5);
}

TEST(AnswerChoice, KeepsTheBestIterate) {
  AnswerChoice choice(kTolerances);
  EXPECT_FALSE(choice.is_solution());
  EXPECT_TRUE(choice.take(norms(1e-3, 0, 0, 0)));
  EXPECT_TRUE(choice.take(norms(4e-10, 1e-15, 0, 1e-9)));
  EXPECT_TRUE(choice.is_solution());
  EXPECT_FALSE(choice.take(norms(2.2e-4, 0, 0, 0)));
  EXPECT_FALSE(choice.take(norms(2.2e-4, 0, 0, 0), true));
  EXPECT_TRUE(choice.is_solution());
}

TEST(AnswerChoice, OneLargeNormOutweighsSmallOnes) {
  AnswerChoice choice(kTolerances);
  EXPECT_TRUE(choice.take(norms(1e-4, 1e-12, 0, 0)));
  // The largest norm is smaller, but the gap decides.
  EXPECT_FALSE(choice.take(norms(0, 1e-5, 0, 0)));
  EXPECT_FALSE(choice.take(norms(0, 0, 0, 1e-1)));
}

TEST(AnswerChoice, TakesPreferredIterateIfItSolves) {
  AnswerChoice choice(kTolerances);
  EXPECT_TRUE(choice.take(norms(1e-10, 0, 0, 0)));
  EXPECT_FALSE(choice.take(norms(1e-8, 0, 0, 0)));
  EXPECT_TRUE(choice.take(norms(1e-8, 0, 0, 0), true));
  EXPECT_TRUE(choice.take(norms(1e-9, 0, 0, 0)));
}

TEST(AnswerChoice, NonFiniteIteratesAreWorst) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  AnswerChoice choice(kTolerances);
  EXPECT_TRUE(choice.take(norms(nan, 0, 0, 0)));
  EXPECT_TRUE(choice.has_answer());
  EXPECT_FALSE(choice.is_solution());
  EXPECT_FALSE(choice.take(norms(0, 0, 0, nan)));
  EXPECT_TRUE(choice.take(norms(1e3, 1, 1, 1)));
  EXPECT_FALSE(choice.take(norms(0, nan, 0, 0), true));
}

TEST(AnswerChoice, ForgetsItsAnswer) {
  AnswerChoice choice(kTolerances);
  EXPECT_TRUE(choice.take(norms(0, 0, 0, 0)));
  choice.forget();
  EXPECT_FALSE(choice.has_answer());
  EXPECT_FALSE(choice.is_solution());
  EXPECT_TRUE(choice.take(norms(1, 1, 1, 1)));
}

}  // namespace
}  // namespace conddp
