// Output of problems with controls that are linear between knots.
#include <sstream>

#include <gtest/gtest.h>

#include "output/report/certificate_report.hpp"
#include "output/solution/csv.hpp"
#include "support/solved_example.hpp"

namespace conddp {
namespace {

const std::string kSwing = R"(conddp: 1
system: {type: pendulum}
initial_state: {values: {theta: 0.4}}
integrator: INTEGRATOR
controls: linear
phases:
  - {name: start, choose: omega, lower: 0, upper: 0.5}
  - {name: swing, knots: 6, dt: 0.1}
costs: {effort: {residual: control, weight: 0.1}}
constraints: {torque: {bounds: control, lower: -2, upper: 3}}
terminal: {costs: {goal: {residual: state, reference: {values: {theta: 1}}, weight: 20}}}
solver: {name: SOLVER}
)";

SolvedExample solved(std::string text, const std::string& integrator, const std::string& solver) {
  text.replace(text.find("INTEGRATOR"), 10, integrator);
  text.replace(text.find("SOLVER"), 6, solver);
  return SolvedExample(ProblemText{text});
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(LinearControlsAnswer, IsCertified) {
  for (const auto& [integrator, solver] :
       {std::pair("rk4", "box_ddp"), std::pair("rk4", "altro"), std::pair("radau3", "ipopt")}) {
    const SolvedExample answer = solved(kSwing, integrator, solver);
    EXPECT_EQ(answer.result->status, SolveStatus::converged) << answer.result->message;
    EXPECT_EQ(failures(answer.judge(answer.document)), "") << integrator << ' ' << solver;
  }
}

TEST(LinearControlsAnswer, FailsIfANodalControlIsForged) {
  const SolvedExample answer = solved(kSwing, "rk4", "box_ddp");
  OrderedJson forged = answer.document;
  add_to(forged["trajectory"]["x"][3].back(), 1e-3);
  EXPECT_NE(failures(answer.judge(forged)).find("[gap]"), std::string::npos);
}

TEST(LinearControlsAnswer, HasControlsAtAllNodesInItsTable) {
  const SolvedExample answer = solved(kSwing, "rk4", "box_ddp");
  const Trajectory& trajectory = answer.result->trajectory;
  const auto lines = lines_of(trajectory_csv(answer.built, trajectory, {}));
  ASSERT_EQ(lines.size(), 8u);
  EXPECT_EQ(lines[0], "t [s],phase,theta [rad],omega [rad/s],torque [Nm]");
  for (int k = 1; k <= trajectory.knots(); ++k) {
    const std::string torque = lines[k].substr(lines[k].rfind(',') + 1);
    EXPECT_EQ(std::stod(torque), trajectory.x(k)[3]) << k;
  }
}

}  // namespace
}  // namespace conddp
