#include "ocp/problem/node_values.hpp"

#include <gtest/gtest.h>

#include "support/block_on_slides.hpp"

namespace conddp {
namespace {

/// A block that the world holds and then releases.
ShootingProblem held_block(Integrator integrator) {
  const auto phase = [&](const std::shared_ptr<const MultibodySystem>& system) {
    return testing::tracking_phase(system, integrator, 3, 0.1,
                                   {.goal = std::vector<double>(6, 0.1),
                                    .q = std::vector<double>(6, 1.0),
                                    .r = std::vector<double>(3, 1.0)},
                                   -testing::kFree, testing::kFree);
  };
  return testing::block_problem(
      {phase(testing::block_system({{.name = "grip"}})), phase(testing::block_system())});
}

Trajectory moved(const ShootingProblem& problem) {
  Trajectory t = problem.create_trajectory();
  for (int k = 0; k <= problem.knots(); ++k) {
    t.x(k).setConstant(0.01 * k);
    if (k < problem.knots()) t.u(k) << 1 + k, 2, 3;
  }
  return t;
}

TEST(NodeValues, MatchTheOutputsOfEachNode) {
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::rk4}) {
    const ShootingProblem problem = held_block(integrator);
    const Trajectory t = moved(problem);
    const NodeValues values(problem, t);
    EXPECT_TRUE(values.all_finite());
    EXPECT_TRUE(values.are_at(moved(problem)));
    Trajectory other = t;
    other.u(5)[2] += 1e-15;
    EXPECT_FALSE(values.are_at(other));
    NodeEvaluation nodes(problem);
    for (int k = 0; k <= problem.knots(); ++k) {
      const KnotWorkspace<double>& work = nodes.at(k, t);
      ASSERT_EQ(values.term_costs(k).size(), work.term_costs.size());
      for (std::size_t i = 0; i < work.term_costs.size(); ++i)
        EXPECT_EQ(values.term_costs(k)[i], work.term_costs[i]) << k;
      if (k == problem.knots()) break;
      for (int i = 0; i < problem.nx(); ++i) EXPECT_EQ(values.next()(i, k), work.next()[i]) << k;
    }
  }
}

/// Forces belong to the knot's own state, even if the step evaluates others.
TEST(NodeValues, IncludeForcesOfHeldContacts) {
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::rk4}) {
    const ShootingProblem problem = held_block(integrator);
    Trajectory t = moved(problem);
    for (int k = 0; k <= problem.knots(); ++k) t.x(k).tail(3).setZero();
    const NodeValues values(problem, t);
    for (int k = 0; k < problem.knots(); ++k) {
      ASSERT_EQ(values.contacts(k).size(), k < 3 ? 1u : 0u) << k;
      if (values.contacts(k).empty()) continue;
      const HeldContact& held = values.contacts(k)[0];
      EXPECT_NEAR(held.force.linear[0], -t.u(k)[0], 1e-9) << k;
      EXPECT_NEAR(held.force.linear[1], -t.u(k)[1], 1e-9) << k;
      EXPECT_NEAR(held.force.linear[2], 2 * 9.81 - t.u(k)[2], 1e-9) << k;
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(held.world.p[i], t.x(k)[i], 1e-12) << k;
    }
  }
}

TEST(NodeValues, ReportNonFiniteNumbers) {
  const ShootingProblem problem = held_block(Integrator::semi_implicit_euler);
  Trajectory t = moved(problem);
  t.u(4)[1] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(NodeValues(problem, t).all_finite());
  // The square overflows at the last node, which has no next state.
  t = moved(problem);
  t.x(problem.knots())[0] = 1e200;
  EXPECT_FALSE(NodeValues(problem, t).all_finite());
}

}  // namespace
}  // namespace conddp
