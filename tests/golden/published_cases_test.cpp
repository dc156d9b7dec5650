// Constrained problems from the literature: published costs, and the last stage of altro on them.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

SolveResult solve_by_altro(const std::string& name) {
  Diagnostics out;
  const auto file = source_tree() / "problems" / (name + ".yaml");
  const auto spec = read_problem(file, {}, out);
  EXPECT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  EXPECT_TRUE(built) << format_diagnostics(out, false);
  return solve(*built->problem, "altro", spec->solver.options, built->guess);
}

/// Costs at ALTRO's exit and after polishing (Howell, Jackson, Manchester 2019, and its public
/// code).
struct Published {
  std::string problem;
  double exit, polished;
};

class PublishedCase : public ::testing::TestWithParam<Published> {};

TEST_P(PublishedCase, IsMet) {
  const Published& p = GetParam();
  const SolveResult result = solve_by_altro(p.problem);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_LE(result.residuals.constraint, 1e-8);
  EXPECT_LE(result.residuals.stationarity, 1e-6);
  EXPECT_NEAR(result.cost, p.polished, 1e-4 * p.polished);
  // If its exit violates the constraints, a solver may be below the optimum.
  EXPECT_LE(result.cost, std::max(p.exit, p.polished) * (1 + 1e-4));
}

INSTANTIATE_TEST_SUITE_P(Altro, PublishedCase,
                         ::testing::Values(Published{"double_integrator_limits", 0.743623,
                                                     0.744087},
                                           Published{"pendulum_goal", 0.024546, 0.018405},
                                           Published{"cartpole_goal", 1.551983, 1.495874},
                                           Published{"unicycle_obstacles", 9.43399, 9.43375}),
                         [](const auto& p) { return p.param.problem; });

/// Newton's method reduces this: its iterates violate constraints or leave gaps.
double infeasibility(const IterationRecord& r) { return std::max(r.constraint, r.gap); }

class LastStage : public ::testing::TestWithParam<std::string> {};

TEST_P(LastStage, ConvergesQuadratically) {
  const SolveResult result = solve_by_altro(GetParam());
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  std::size_t first = result.log.size() - 1;
  while (first > 0 && result.log[first].newton > result.log[first - 1].newton) --first;
  const std::size_t steps = result.log.size() - 1 - first;
  EXPECT_GE(infeasibility(result.log[first]), 1e-4);
  EXPECT_GE(steps, 1u);
  EXPECT_LE(steps, 5u);
  EXPECT_LE(infeasibility(result.log.back()), 1e-10);
  // Each step doubles the correct digits until rounding; the first step also settles the active
  // constraints.
  for (std::size_t i = first + 2; i < result.log.size(); ++i) {
    const double before = infeasibility(result.log[i - 1]), after = infeasibility(result.log[i]);
    EXPECT_EQ(result.log[i].step, 1);
    const double quadratic = 200 * before * before;
    EXPECT_LE(after, std::max({1e-12, std::pow(before, 1.4), quadratic})) << "step " << i - first;
  }
}

INSTANTIATE_TEST_SUITE_P(Altro, LastStage,
                         ::testing::Values("double_integrator_limits", "cartpole_goal",
                                           "unicycle_obstacles", "car_parking_goal", "arm_waypoint",
                                           "arm_reach_pose", "powered_descent"),
                         [](const auto& p) { return p.param; });

}  // namespace
}  // namespace conddp
