// Identity of problem files.
#include <gtest/gtest.h>

#include "problem_file/assemble/build_problem.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

std::string identity(const std::string& text, const std::vector<std::string>& settings = {},
                     const std::vector<std::string>& drop = {}) {
  const Loaded loaded(text, settings, {.drop = drop});
  EXPECT_TRUE(loaded.built) << loaded.all();
  return loaded.built ? problem_sha256(*loaded.built) : "";
}

TEST(ProblemIdentity, IgnoresSpelling) {
  const std::string text(kPendulum);
  const std::string known = identity(text);
  EXPECT_EQ(known.size(), 64u);
  EXPECT_EQ(identity("# A comment.\n" + text), known);
  EXPECT_EQ(identity(replaced(text, "weight: 0.5", "weight:   5.0e-1")), known);
  EXPECT_EQ(identity(replaced(text, "bounds: control, lower: -3", "lower: -3.0, bounds: control")),
            known);
  EXPECT_EQ(identity(replaced(text, "initial_state: {values: {theta: 0.1}}\nintegrator: rk4",
                              "integrator: rk4\ninitial_state:\n  values:\n    theta: 0.1")),
            known);
}

TEST(ProblemIdentity, IgnoresNameSolverGuessAndPerturbation) {
  const std::string text(kPendulum);
  const std::string known = identity(text);
  EXPECT_EQ(identity(replaced(text, "name: test", "name: other\ndescription: Another.")), known);
  EXPECT_EQ(identity(replaced(text, "name: box_ddp", "name: ipopt, max_iterations: 7")), known);
  EXPECT_EQ(identity(text + "initial_guess: {controls: {constant: {torque: 0.1}}}\n"), known);
  EXPECT_EQ(identity(text, {"solver.tolerances.gap=1e-9"}), known);
  EXPECT_EQ(identity(text, {"perturbation={initial_state: 0.1, seed: 2}"}), known);
  EXPECT_EQ(identity(text, {}, {"torque"}), known) << "with all constraints, whatever is dropped";
}

TEST(ProblemIdentity, ChangesWithTheProblem) {
  const std::string text(kPendulum);
  const std::string known = identity(text);
  EXPECT_NE(identity(replaced(text, "weight: 0.5", "weight: 0.6")), known);
  EXPECT_NE(identity(replaced(text, "theta: 0.1", "theta: 0.2")), known);
  EXPECT_NE(identity(replaced(text, "upper: 3", "upper: 4")), known);
  EXPECT_NE(identity(replaced(text, "knots: 4", "knots: 5")), known);
  EXPECT_NE(identity(text, {"costs.effort.weight=0.6"}), known);
}

TEST(ProblemIdentity, ChangesWithTheRobot) {
  const Loaded loaded{std::string(kCartpole)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  BuiltProblem other = *loaded.built;
  EXPECT_EQ(problem_sha256(other), problem_sha256(*loaded.built));
  other.plant.parts.front().sha256.front() ^= 1;
  EXPECT_NE(problem_sha256(other), problem_sha256(*loaded.built));
}

}  // namespace
}  // namespace conddp
