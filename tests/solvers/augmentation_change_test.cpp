#include "solvers/constraints/augmentation_change.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "support/dense_convex.hpp"

namespace conddp {
namespace {

using testing::Added;
using testing::cuts;
using testing::LinearQuadratic;
using testing::with_constraints;

/// Equal penalties within a constraint, and shifts that put rows on both sides of bounds.
Augmentation random_augmentation(const ShootingProblem& problem, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-4, 4), exponent(-2, 3);
  Augmentation augmentation(problem);
  for (const NodeConstraint& c : problem.constraints()) {
    augmentation.penalty.segment(c.row, c.term->rows).setConstant(std::pow(10, exponent(random)));
    for (int r = 0; r < c.term->rows; ++r) augmentation.shift[c.row + r] = shift(random);
  }
  return augmentation;
}

class AugmentationChanges : public ::testing::TestWithParam<Softness> {};

// Whatever was and is active, the result matches differentiation.
TEST_P(AugmentationChanges, MatchDifferentiation) {
  std::mt19937 random(1);
  for (const unsigned seed : {1u, 2u, 3u}) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 8, -3, 3);
    std::vector<Added> list = cuts(lq);
    for (Added& cut : list) {
      cut.softness = GetParam();
      cut.weight = 0.5;
    }
    const ShootingProblem problem = with_constraints(*lq.problem, list);
    Evaluator evaluator(problem);
    Linearization changed(problem), expected(problem);
    AugmentationChange change(problem);
    const Trajectory trajectory = problem.create_trajectory();
    Augmentation from = random_augmentation(problem, random);
    evaluator.differentiate(trajectory, changed, &from);
    for (int i = 0; i < 10; ++i) {
      const Augmentation to = random_augmentation(problem, random);
      EXPECT_TRUE(change.apply(from, to, changed));
      evaluator.differentiate(trajectory, expected, &to);
      EXPECT_NEAR(changed.augmentation.sum(), expected.augmentation.sum(),
                  1e-11 * expected.augmentation.sum());
      for (int k = 0; k <= problem.knots(); ++k) {
        const KnotLinearization &a = changed.knots[k], &b = expected.knots[k];
        const double size = 1e3 + b.hessian().norm();
        EXPECT_LT((a.gradient - b.gradient).norm(), 1e-12 * size) << k;
        EXPECT_LT((a.hessian() - b.hessian()).norm(), 1e-12 * size) << k;
      }
      EXPECT_FALSE(change.apply(to, to, changed));
      from = to;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Constraints, AugmentationChanges,
                         ::testing::Values(Softness::hard, Softness::l1), [](const auto& test) {
                           return test.param == Softness::hard ? "hard" : "soft";
                         });

}  // namespace
}  // namespace conddp
