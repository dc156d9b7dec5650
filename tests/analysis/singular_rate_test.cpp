#include "analysis/findings/singular_rate.hpp"

#include <gtest/gtest.h>

#include "support/expression_systems.hpp"

namespace conddp {
namespace {

/// One knot of 0.1 s of a system with states x and y; y follows `equation`.
std::optional<SingularRate> singular(const std::string& equation, double x,
                                     SystemKind kind = SystemKind::first_order) {
  const auto system = expression_system({.kind = kind,
                                         .states = expression_numbers({"x", "y"}),
                                         .controls = expression_columns({"u"}),
                                         .equations = {{"x", "u"}, {"y", equation}}});
  const ShootingProblem problem(
      {x, 1},
      {{.name = "go",
        .model = std::make_shared<KnotModel>(
            system, kind == SystemKind::discrete ? Integrator::discrete : Integrator::rk4),
        .dt = {0.1},
        .cost_scale = {1}}},
      {.name = "end",
       .model = std::make_shared<KnotModel>(system, Integrator::none),
       .dt = {0},
       .cost_scale = {1}});
  return singular_rate(problem, problem.create_trajectory(), 0);
}

TEST(SingularRate, NamesStateThatADenominatorNeeds) {
  const auto found = singular("cos(y)/x", 0);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->row, "y");
  EXPECT_EQ(found->state, "x");
  EXPECT_EQ(found->value, 0);
  EXPECT_EQ(found->nearby, 1);  // closer to 0, the rate varies strongly within a step
  EXPECT_FALSE(singular("cos(y)/x", found->nearby));
}

TEST(SingularRate, NamesNoStateIfNoneHelps) {
  const auto found = singular("sqrt(x - 300)", 0);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->row, "y");
  EXPECT_TRUE(found->state.empty());
}

TEST(SingularRate, CoversNextStatesToo) {
  const auto found = singular("log(x)", 0, SystemKind::discrete);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->state, "x");
  EXPECT_EQ(found->nearby, 0.01);
}

TEST(SingularRate, IsNotFoundInFiniteEquations) { EXPECT_FALSE(singular("1e6*x*y", 3)); }

}  // namespace
}  // namespace conddp
