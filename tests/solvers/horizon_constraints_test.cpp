#include "solvers/horizon_constraints.hpp"

#include <gtest/gtest.h>

#include "ocp/acts.hpp"
#include "support/conic_problems.hpp"

namespace conddp::testing {
namespace {

/// A conic problem linearised at zero, and steps from there.
struct Horizon {
  Horizon()
      : conic(1, middle_size()),
        augmentation(*conic.problem),
        linearization(*conic.problem),
        constraints(*conic.problem) {
    const ShootingProblem& problem = *conic.problem;
    augmentation.penalty.setOnes();
    Acts(problem).differentiate(problem.create_trajectory(), linearization, &augmentation);
    for (int k = 0; k <= problem.knots(); ++k)
      z.push_back(Eigen::VectorXd::Zero(problem.knot(k).model->nz()));
    constraints.start(linearization, augmentation);
  }

  ConicLinearQuadratic conic;
  Augmentation augmentation;
  Linearization linearization;
  HorizonConstraints constraints;
  std::vector<Eigen::VectorXd> z;
  std::optional<int> last;
};

// Sweeps begin again where a model of rows changed last, so that node has to be told.
TEST(HorizonConstraints, TellTheLastNodeWhoseRowsCrossed) {
  Horizon horizon;
  auto& [conic, augmentation, linearization, constraints, z, last] = horizon;

  EXPECT_EQ(constraints.revise(z, 0, linearization, last), 0);
  EXPECT_FALSE(last.has_value());
  z[3].setConstant(100);
  z[7].setConstant(-100);
  EXPECT_GE(constraints.revise(z, 0, linearization, last), 2);
  EXPECT_EQ(last, 7);
  last.reset();
  EXPECT_EQ(constraints.revise(z, 0, linearization, last), 0);
  EXPECT_FALSE(last.has_value());
  z[7].setZero();
  EXPECT_GE(constraints.revise(z, 0, linearization, last), 1);
  EXPECT_EQ(last, 7);
}

TEST(HorizonConstraints, LeaveAModelThatIsOffByLessThanAllowed) {
  Horizon horizon;
  auto& [conic, augmentation, linearization, constraints, z, last] = horizon;
  z[3].setConstant(100);
  const Eigen::VectorXd gradient = linearization.knots[3].gradient;
  EXPECT_EQ(constraints.revise(z, 1e12, linearization, last), 0);
  EXPECT_EQ(linearization.knots[3].gradient, gradient);
  EXPECT_GE(constraints.revise(z, 1e-12, linearization, last), 1);
  EXPECT_NE(linearization.knots[3].gradient, gradient);
}

// The next iterate's model begins where the last step settled, with its multipliers, once.
TEST(HorizonConstraints, ExpectTheRowsOfTheStepBefore) {
  Horizon horizon;
  auto& [conic, augmentation, linearization, constraints, z, last] = horizon;
  z[3].setConstant(100);
  ASSERT_GE(constraints.revise(z, 0, linearization, last), 1);
  const Eigen::VectorXd settled = linearization.knots[3].gradient;
  ASSERT_EQ(constraints.revise(z, 0, linearization, last), 0);
  constraints.settle();
  ASSERT_TRUE(constraints.restore(linearization));
  const Eigen::VectorXd own = linearization.knots[3].gradient;

  constraints.start(linearization, augmentation);
  constraints.expect(linearization);
  EXPECT_LT((linearization.knots[3].gradient - settled).norm(), 1e-9 * settled.norm());
  EXPECT_EQ(constraints.revise(z, 0, linearization, last), 0);
  constraints.restore(linearization);
  EXPECT_EQ(linearization.knots[3].gradient, own);
  constraints.start(linearization, augmentation);
  constraints.expect(linearization);
  EXPECT_EQ(linearization.knots[3].gradient, own) << "what was expected once is past";
}

}  // namespace
}  // namespace conddp::testing
