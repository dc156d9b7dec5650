// Impossible motions: every solver reports them as infeasible soon, with a valid certificate, but
// not before reaching a point of least violation.
#include <gtest/gtest.h>

#include "output/report/certificate_report.hpp"
#include "output/report/solution_certificate.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

struct ImpossibleMotion {
  std::string name;
  std::string file;
  std::vector<std::string> settings;
  bool decided = true;  ///< false: solvers may leave infeasibility undecided
};

struct Loaded {
  std::vector<std::string> settings;
  ProblemSpec spec;
  BuiltProblem built;
};

std::optional<Loaded> load(const ImpossibleMotion& motion, const std::string& solver) {
  std::vector<std::string> settings = motion.settings;
  settings.push_back("solver.name=" + solver);
  Diagnostics out;
  auto spec = read_problem(source_tree() / "problems" / motion.file, settings, out);
  auto built = spec ? build_problem(*spec, {}, out) : std::nullopt;
  EXPECT_TRUE(built) << format_diagnostics(out, false);
  if (!built) return std::nullopt;
  return Loaded{std::move(settings), *std::move(spec), *std::move(built)};
}

const Check* least_violation(const Certificate& certificate) {
  for (const Check& check : certificate.checks)
    if (check.name == "least violation") return &check;
  return nullptr;
}

SolutionCertificate certify(const Loaded& loaded, const SolverInfo& solver,
                            const SolveResult& result) {
  const OrderedJson document =
      OrderedJson::parse(solution_json({loaded.built, solver, result, loaded.settings}).dump());
  return certify_solution(document, loaded.built, false);
}

/// A goal for a heavy arm, within 0.05 rad, under torques of 2 Nm: the arm can only whirl.
const ImpossibleMotion kWeakArm{
    "weak_arm",
    "arm_reach.yaml",
    {"constraints.torque={bounds: control, lower: -2, upper: 2}",
     "robot.configurations.goal={joints: {joint_2: 0.9, joint_4: -1.2, joint_6: 1.54}}",
     "terminal={constraints: {goal: {residual: joint_position, reference: goal, lower: -0.05, "
     "upper: 0.05}}}"},
    false};

/// A pendulum held nearly level for 1.5 s although 2 Nm carry less than half of its weight.
const ImpossibleMotion kHeld{
    "held_pendulum",
    "pendulum_goal.yaml",
    {"phases=[{name: swing, knots: 30, duration: 1.5}, {name: hold, knots: 30, duration: 1.5}]",
     "constraints={torque: {bounds: control, lower: -2, upper: 2}, held: {residual: state, "
     "columns: "
     "[theta], phases: [hold], lower: 1.5208, upper: 1.6208}}",
     "terminal={}"}};

/// A swing-up in a tenth of the required time.
const ImpossibleMotion kHurried{
    "hurried_pendulum", "pendulum_goal.yaml", {"phases.0.duration=0.3"}};

class Impossible : public ::testing::TestWithParam<ImpossibleMotion> {};

TEST_P(Impossible, IsCertifiedIfReported) {
  for (const char* name : {"altro", "proxddp", "ipopt"}) {
    const auto loaded = load(GetParam(), name);
    ASSERT_TRUE(loaded);
    const SolverInfo& solver = *find_solver(name);
    const SolveResult result =
        solve(*loaded->built.problem, solver, loaded->spec.solver.options, loaded->built.guess);
    if (!GetParam().decided && result.status != SolveStatus::infeasible) {
      EXPECT_FALSE(is_success(result.status)) << name;
      EXPECT_NE(result.message.find("has not been decided"), std::string::npos) << result.message;
      continue;
    }
    EXPECT_EQ(result.status, SolveStatus::infeasible) << name << ": " << result.message;
    const SolutionCertificate certificate = certify(*loaded, solver, result);
    EXPECT_TRUE(certificate.checks.holds()) << name << certificate_line(certificate);
    const Check* check = least_violation(certificate.checks);
    ASSERT_NE(check, nullptr) << name;
    EXPECT_TRUE(check->holds) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Impossible, ::testing::Values(kWeakArm, kHeld, kHurried),
                         [](const auto& test) { return test.param.name; });

/// A stalled augmented Lagrangian is not a point of least violation.
TEST(Infeasible, StalledPenaltyMethodIsNotInfeasible) {
  auto loaded = load(kWeakArm, "altro");
  ASSERT_TRUE(loaded);
  const SolverInfo& solver = *find_solver("altro");
  SolverOptions options = loaded->spec.solver.options;
  options.max_iterations = 30;
  SolveResult result = solver.run(*loaded->built.problem, options, loaded->built.guess);
  result.status = SolveStatus::infeasible;
  const SolutionCertificate certificate = certify(*loaded, solver, result);
  const Check* check = least_violation(certificate.checks);
  ASSERT_NE(check, nullptr);
  EXPECT_FALSE(check->holds);
  EXPECT_GT(check->found, 0.01);
}

}  // namespace
}  // namespace conddp
