#include "solvers/horizon_constraints.hpp"

#include <gtest/gtest.h>

#include "ocp/acts.hpp"
#include "support/conic_problems.hpp"

namespace conddp::testing {
namespace {

// Sweeps begin again where a model of rows changed last, so that node has to be told.
TEST(HorizonConstraints, TellTheLastNodeWhoseRowsCrossed) {
  const ConicLinearQuadratic conic(1, middle_size());
  const ShootingProblem& problem = *conic.problem;
  Augmentation augmentation(problem);
  augmentation.penalty.setOnes();
  Linearization linearization(problem);
  Acts(problem).differentiate(problem.create_trajectory(), linearization, &augmentation);
  std::vector<Eigen::VectorXd> z;
  for (int k = 0; k <= problem.knots(); ++k)
    z.push_back(Eigen::VectorXd::Zero(problem.knot(k).model->nz()));
  HorizonConstraints constraints(problem);
  constraints.start(linearization, augmentation);

  std::optional<int> last;
  EXPECT_EQ(constraints.revise(z, linearization, last), 0);
  EXPECT_FALSE(last.has_value());
  z[3].setConstant(100);
  z[7].setConstant(-100);
  EXPECT_GE(constraints.revise(z, linearization, last), 2);
  EXPECT_EQ(last, 7);
  last.reset();
  EXPECT_EQ(constraints.revise(z, linearization, last), 0);
  EXPECT_FALSE(last.has_value());
  z[7].setZero();
  EXPECT_GE(constraints.revise(z, linearization, last), 1);
  EXPECT_EQ(last, 7);
}

}  // namespace
}  // namespace conddp::testing
