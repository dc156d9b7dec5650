// Simulated guesses of contact-implicit example problems, judged by the problems' own constraints.
#include <gtest/gtest.h>

#include "analysis/contact/simulated_contacts.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

BuiltProblem example(const std::string& name) {
  Diagnostics out;
  const auto file = source_tree() / "problems" / (name + ".yaml");
  const auto spec = read_problem(file, {}, out);
  if (!spec) throw std::runtime_error(format_diagnostics(out, false));
  auto built = build_problem(*spec, {}, out);
  if (!built) throw std::runtime_error(format_diagnostics(out, false));
  return *std::move(built);
}

class SimulatedGuess : public ::testing::TestWithParam<const char*> {};

/// Pyramids, cones, stops and dry friction of joints are among them. A contact that sticks may
/// creep by as much as the simulator's tolerance allows.
TEST_P(SimulatedGuess, SatisfiesTheSteppingEquations) {
  const BuiltProblem built = example(GetParam());
  const ShootingProblem& problem = *built.problem;
  const auto simulated = simulated_guess(problem, built.guess);
  ASSERT_TRUE(simulated);
  Evaluation at(problem);
  Evaluator(problem).evaluate(*simulated, at);
  EXPECT_LT(at.gap.cwiseAbs().maxCoeff(), 1e-12);
  for (const ConstraintViolation& v : violations_by_name(problem, at.constraint))
    if (v.name == "stepping" || v.name == "complementarity") {
      EXPECT_LT(v.value, 1e-5) << v.name << " at node " << v.node;
    }
}

INSTANTIATE_TEST_SUITE_P(Examples, SimulatedGuess,
                         ::testing::Values("block_slope", "cartpole_walls", "crate_tumble",
                                           "finger_spinner", "footed_hopper", "push_box",
                                           "quadruped_hop"),
                         [](const auto& one) { return std::string(one.param); });

TEST(NoSimulatedGuess, OfScheduledContacts) {
  const BuiltProblem built = example("cartpole_swingup");
  EXPECT_FALSE(simulated_guess(*built.problem, built.guess));
}

}  // namespace
}  // namespace conddp
