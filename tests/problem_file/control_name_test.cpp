#include <gtest/gtest.h>

#include "analysis/certificate/check.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

TEST(ControlName, NamesComponentsOfAChosenFirstState) {
  const Loaded loaded(replaced(kPendulum, "  - {name: first",
                               "  - {name: start, choose: [omega]}\n  - {name: first"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(control_name(problem, 0, 0), "omega");
  EXPECT_EQ(control_name(problem, 1, 0), "torque");
  EXPECT_EQ(control_name(problem, 1, 1), "");
  EXPECT_EQ(control_name(problem, 1, -1), "");
  EXPECT_EQ(control_name(problem, problem.knots(), 0), "");
}

}  // namespace
}  // namespace conddp
