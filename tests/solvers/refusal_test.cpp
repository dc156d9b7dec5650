// Solvers that support a problem, and the messages of the others.
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

using SolverNames = std::vector<std::string_view>;

/// A phase "go" of two knots x⁺ = x + u in the plane with a constraint on x.
ShootingProblem constrained_steps(ConstraintKind kind, const std::vector<double>& bounds,
                                  double weight = 0, double control_limit = testing::kFree,
                                  bool at_end = false) {
  const auto system = linear_system(Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity(),
                                    Eigen::Vector2d::Zero());
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  running->add_cost("effort", control_residual(2, 2), {});
  running->set_control_bounds({-testing::kFree, -control_limit}, {testing::kFree, control_limit});
  (at_end ? end : running)
      ->add_constraint(make_constraint("fence",
                                       kind == ConstraintKind::complementarity
                                           ? control_residual(2, 2)
                                           : state_residual(running->manifold()),
                                       kind, 1, weight > 0 ? Softness::l1 : Softness::hard));
  std::vector<double> constraint = {0, 0};
  constraint.insert(constraint.end(), bounds.begin(), bounds.end());
  constraint.push_back(1);
  if (weight > 0) constraint.push_back(weight);
  std::vector<double> knot = {0, 0, 1}, both;
  if (!at_end) knot.insert(knot.end(), constraint.begin(), constraint.end());
  for (int k = 0; k < 2; ++k) both.insert(both.end(), knot.begin(), knot.end());
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "go", .model = running, .dt = {1, 1}, .cost_scale = {1, 1}, .parameters = both});
  Phase terminal{.name = "end", .model = end, .dt = {0}, .cost_scale = {1}};
  if (at_end) terminal.parameters = constraint;
  return ShootingProblem({0, 0}, std::move(phases), std::move(terminal));
}

SolverNames those_that_take(const ShootingProblem& problem) {
  SolverNames names;
  for (const SolverInfo& info : solvers())
    if (!unsupported(info, problem)) names.push_back(info.name);
  return names;
}

TEST(Refusals, FollowFromConstraintsAndBounds) {
  const SolverNames all = {"altro", "proxddp", "ipddp", "ipopt"};
  constexpr double kFree = testing::kFree;
  EXPECT_EQ(those_that_take(constrained_steps(ConstraintKind::bounds, {-1, -1, 1, 1})), all);
  EXPECT_EQ(those_that_take(constrained_steps(ConstraintKind::bounds, {-1, 0, kFree, 0})), all);
  EXPECT_EQ(those_that_take(constrained_steps(ConstraintKind::bounds, {0, 0, kFree, 0})), all);
  EXPECT_EQ(those_that_take(constrained_steps(ConstraintKind::second_order_cone, {})), all);
  EXPECT_EQ(those_that_take(constrained_steps(ConstraintKind::complementarity, {})),
            (SolverNames{"ipddp", "ipopt"}));
  // Equalities; one row may be free.
  const SolverNames more = {"intro", "altro", "proxddp", "ipddp", "ipopt"};
  EXPECT_EQ(those_that_take(constrained_steps(ConstraintKind::bounds, {1, 2, 1, 2})), more);
  EXPECT_EQ(those_that_take(constrained_steps(ConstraintKind::bounds, {1, -kFree, 1, kFree})),
            more);
  EXPECT_EQ(those_that_take(constrained_steps(ConstraintKind::bounds, {1, 2, 1, 2}, 10)), all);
  EXPECT_EQ(those_that_take(constrained_steps(ConstraintKind::bounds, {1, 2, 1, 2}, 0, 3)), all);
}

std::string reason(const char* solver, const ShootingProblem& problem) {
  return unsupported(*find_solver(solver), problem).value_or("");
}

TEST(Refusals, NameTheConstraintAndCapableSolvers) {
  const ShootingProblem fence = constrained_steps(ConstraintKind::bounds, {-1, -1, 1, 1});
  EXPECT_EQ(reason("box_fddp", fence),
            "box_fddp does not support the constraint 'fence' (phase 'go'); supported by altro, "
            "proxddp, ipddp, ipopt");
  EXPECT_EQ(reason("intro", fence),
            "intro does not support the inequality 'fence' (phase 'go'); supported by altro, "
            "proxddp, ipddp, ipopt");
  EXPECT_EQ(reason("intro", constrained_steps(ConstraintKind::bounds, {1, 2, 1, 2}, 10)),
            "intro does not support the soft constraint 'fence' (phase 'go'); supported by altro, "
            "proxddp, ipddp, ipopt");
  EXPECT_EQ(reason("box_ddp", constrained_steps(ConstraintKind::bounds, {1, 2, 1, 2}, 0,
                                                testing::kFree, true)),
            "box_ddp does not support the constraint 'fence' (terminal node); supported by intro, "
            "altro, proxddp, ipddp, "
            "ipopt");
}

TEST(Refusals, NameTheBound) {
  const ShootingProblem problem = testing::pendulum_swing_up(3);
  const std::string text = reason("ddp", problem);
  EXPECT_NE(text.find("-3 <= "), std::string::npos) << text;
  EXPECT_NE(text.find(" <= 3 in phase 'all'"), std::string::npos) << text;
  EXPECT_NE(text.find("clipped by ilqr_clip"), std::string::npos) << text;
  EXPECT_EQ(reason("ddp", testing::pendulum_swing_up()), "");
  EXPECT_EQ(reason("ilqr_clip", problem), "");
}

TEST(AutoSolver, TriesSolversWithTheRequestedHessian) {
  const ShootingProblem problem = testing::pendulum_swing_up(3);
  for (const HessianChoice choice : {HessianChoice::exact, HessianChoice::gauss_newton}) {
    SolverNames expected;
    for (const char* name : {"box_fddp", "ipopt"}) {
      const SolverInfo& info = *find_solver(name);
      if (choice == HessianChoice::exact ? info.exact_hessian : info.gauss_newton_hessian)
        expected.push_back(name);
    }
    SolverNames found;
    for (const SolverInfo* info : auto_solvers(problem, {.hessian = choice}))
      found.push_back(info->name);
    EXPECT_EQ(found, expected);
    EXPECT_FALSE(found.empty());
  }
}

}  // namespace
}  // namespace conddp
