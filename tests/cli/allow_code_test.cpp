// Problem files with compiled code run only with permission.
#include <gtest/gtest.h>

#include "process.hpp"

namespace conddp {
namespace {

class AllowCode : public ::testing::Test {
 protected:
  AllowCode()
      : file_(folder_.write("swing.yaml", std::string(R"(conddp: 1
system:
  library: )") + CONDDP_TEST_MODEL +
                                              R"(
  function: swing
  states: {angle: rad, speed: rad/s}
  controls: {torque: Nm}
  parameters: {inertia: 2, weight: 5}
initial_state: {values: {angle: 0.5}}
phases: [{name: only, knots: 20, dt: 0.05}]
costs: {effort: {residual: control, weight: 0.1}}
terminal: {costs: {goal: {residual: state, reference: [1, 0], weight: 20}}}
solver: {name: box_fddp}
)")) {}

  std::string output() const { return folder_.path() / "out"; }

  const TemporaryFolder folder_;
  const std::string file_;
};

TEST_F(AllowCode, LoadsNothingWithoutPermission) {
  for (const char* command : {"check", "solve", "bench"}) {
    const ProcessResult result = run_conddp({command, file_});
    EXPECT_EQ(result.exit_code, 2) << command;
    EXPECT_NE(result.err.find("swing.yaml:3:12: error: '"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("is compiled code, which would run with all your permissions"),
              std::string::npos)
        << result.err;
    EXPECT_NE(result.err.find("--allow-code"), std::string::npos) << result.err;
  }
}

TEST_F(AllowCode, PermissionAllowsCheckSolveAndVerify) {
  const ProcessResult check = run_conddp({"check", "--derivatives", "--allow-code", file_});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  ASSERT_EQ(run_conddp({"solve", file_, "--allow-code", "-o", output()}).exit_code, 0);
  const std::string solution = output() + "/solution.json";
  EXPECT_TRUE(fits_schema("solution", read_file(solution)));
  EXPECT_NE(read_file(solution).find("test_model.so"), std::string::npos);
  EXPECT_EQ(run_conddp({"verify", solution}).exit_code, 2);
  const ProcessResult verified = run_conddp({"verify", solution, "--allow-code"});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_NE(verified.out.find("certified local minimum"), std::string::npos) << verified.out;
  EXPECT_EQ(run_conddp({"bench", file_, "--solvers", "box_fddp", "--repeat", "0", "--allow-code"})
                .exit_code,
            0);
}

/// A problem with a function of the test model in two states and one control.
std::string problem_of(const std::string& function, const std::string& state,
                       const std::string& goal, const std::string& dt = "0.05") {
  return "conddp: 1\nsystem: {library: " + std::string(CONDDP_TEST_MODEL) +
         ", function: " + function +
         ", states: [x, y], controls: [u]}\ninitial_state: {state: " + state +
         "}\nphases: [{knots: 20, dt: " + dt + "}]\n" +
         "costs: {effort: {residual: control, weight: 0.1}}\n" +
         "terminal: {costs: {goal: {residual: state, reference: " + goal +
         ", weight: 20}}}\nsolver: {name: box_fddp}\n";
}

TEST_F(AllowCode, FindsAWrongJacobian) {
  const std::string wrong = folder_.write("wrong.yaml", std::string(R"(conddp: 1
system: {library: )") + CONDDP_TEST_MODEL + R"(, function: crooked, states: [x, y], controls: [u]}
initial_state: {state: [1, 0]}
phases: [{knots: 5, dt: 0.1}]
costs: {effort: {residual: control}, rest: {residual: state}}
solver: {name: box_fddp, max_iterations: 3}
)");
  const ProcessResult check = run_conddp({"check", "--derivatives", "--allow-code", wrong});
  EXPECT_EQ(check.exit_code, 1) << check.out << check.err;
  run_conddp({"solve", wrong, "--allow-code", "-o", output()});
  const ProcessResult verified =
      run_conddp({"verify", output() + "/solution.json", "--allow-code"});
  EXPECT_EQ(verified.exit_code, 1) << verified.err;
  EXPECT_NE(verified.out.find("derivatives of compiled code"), std::string::npos) << verified.out;
}

TEST_F(AllowCode, FindsWrongJacobianOfFastWave) {
  const std::string wrong =
      folder_.write("wrong.yaml", problem_of("wrong_wave", "[100001.57, 0]", "[100001.6, 0]"));
  const ProcessResult check = run_conddp({"check", "--derivatives", "--allow-code", wrong});
  EXPECT_EQ(check.exit_code, 1) << check.out << check.err;
  const ProcessResult solved = run_conddp({"solve", wrong, "--allow-code", "-o", output()});
  EXPECT_NE(solved.exit_code, 0) << solved.out << solved.err;
  const ProcessResult verified =
      run_conddp({"verify", output() + "/solution.json", "--allow-code"});
  EXPECT_EQ(verified.exit_code, 1) << verified.err;
  EXPECT_NE(verified.out.find("derivatives of compiled code"), std::string::npos) << verified.out;
}

TEST_F(AllowCode, FindsAWrongHessian) {
  std::string text = problem_of("bent", "[0.5, 0]", "[1, 0]");
  text.insert(text.find("function:"), "parameters: {inertia: 2, weight: 5}, ");
  const std::string wrong = folder_.write("wrong.yaml", text);
  const ProcessResult check = run_conddp({"check", "--derivatives", "--allow-code", wrong});
  EXPECT_EQ(check.exit_code, 1) << check.out << check.err;
  EXPECT_NE(check.out.find(", Hessian: worst"), std::string::npos) << check.out;
  run_conddp({"solve", wrong, "--allow-code", "-o", output()});
  const ProcessResult verified =
      run_conddp({"verify", output() + "/solution.json", "--allow-code"});
  EXPECT_EQ(verified.exit_code, 1) << verified.err;
  EXPECT_NE(verified.out.find("its Hessian differs from differences of its Jacobian"),
            std::string::npos)
      << verified.out;
}

TEST_F(AllowCode, AcceptsJacobiansAtLargeNumbersKinksAndEdges) {
  struct Case {
    const char *function, *state, *goal, *dt = "0.05";
  };
  const Case cases[] = {{"climb", "[10, 100]", "[130, 100]"},
                        {"climb", "[7.0e+6, 7500]", "[7.0075e+6, 7500]"},
                        {"kink", "[0, 0]", "[1, 0]"},
                        {"edge", "[0, 0]", "[1, 0]"},
                        {"growth", "[0, 0]", "[1, 0]"},
                        {"wave", "[9424.78, 0]", "[9425, 0]"},
                        {"wave", "[100001.57, 0]", "[100001.6, 0]"},
                        {"terrain", "[5.0e+6, 0]", "[5000001, 0]"},
                        {"friction", "[0, 0]", "[0, 0]"},
                        {"hum", "[0, 0, 0]", "[1, 0]", "1.501"}};
  for (const Case& c : cases) {
    const std::string file =
        folder_.write("right.yaml", problem_of(c.function, c.state, c.goal, c.dt));
    const ProcessResult check = run_conddp({"check", "--derivatives", "--allow-code", file});
    EXPECT_EQ(check.exit_code, 0) << c.function << check.out << check.err;
    const ProcessResult solved = run_conddp({"solve", file, "--allow-code", "-o", output()});
    EXPECT_EQ(solved.exit_code, 0) << c.function << solved.out << solved.err;
  }
}

TEST_F(AllowCode, LargeRobotResidualsDoNotImplicateDynamics) {
  const std::string own = std::string("costs.own={residual: library, library: ") +
                          CONDDP_TEST_MODEL + ", function: joint}";
  const ProcessResult check = run_conddp(
      {"check", source("problems/arm_reach.yaml"), "--set", own, "--derivatives", "--allow-code"});
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
}

TEST_F(AllowCode, NamesAFailingJacobian) {
  const std::string file = folder_.write("stuck.yaml", problem_of("stuck", "[1, 0]", "[0, 0]"));
  const ProcessResult solved = run_conddp({"solve", file, "--allow-code", "-o", output()});
  EXPECT_EQ(solved.exit_code, 1) << solved.out << solved.err;
  EXPECT_NE(solved.err.find("the function fails or is not finite"), std::string::npos)
      << solved.err;
}

TEST_F(AllowCode, AnswerWithoutValuesHasNoDerivativesToCheck) {
  const std::string file = folder_.write("torn.yaml", problem_of("torn", "[1, 0]", "[0, 0]"));
  const ProcessResult solved = run_conddp({"solve", file, "--allow-code", "-o", output()});
  EXPECT_EQ(solved.exit_code, 1) << solved.out << solved.err;
  const ProcessResult verified =
      run_conddp({"verify", output() + "/solution.json", "--allow-code"});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  EXPECT_NE(verified.out.find("consistency check passed"), std::string::npos) << verified.out;
}

TEST_F(AllowCode, ExpandedFileCanBeReadAgain) {
  const ProcessResult expanded = run_conddp({"check", "--expand", file_, "--allow-code"});
  ASSERT_EQ(expanded.exit_code, 0) << expanded.err;
  EXPECT_NE(expanded.out.find("gives: rate"), std::string::npos) << expanded.out;
  const std::string again = folder_.write("again.yaml", expanded.out);
  EXPECT_EQ(run_conddp({"check", again, "--allow-code"}).exit_code, 0);
}

TEST_F(AllowCode, BatchWorkersInheritThePermission) {
  const std::string plan = folder_.write("plan.yaml", R"(conddp_batch: 1
problem: swing.yaml
vary: {weight: {key: system.parameters.weight, values: [4, 5, 6]}}
)");
  EXPECT_EQ(run_conddp({"batch", "run", plan, "-o", output()}).exit_code, 2);
  const ProcessResult result =
      run_conddp({"batch", "run", plan, "-o", output(), "--allow-code", "-j", "2"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

}  // namespace
}  // namespace conddp
