// What solve says of answers in unusual units, and of points that are stationary.
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// A pendulum of unit mass and length that hangs at rest.
const std::string kHanging = R"(conddp: 1
name: hanging
system:
  positions: {angle: rad}
  velocities: {rate: rad/s}
  controls: {torque: Nm}
  acceleration: {rate: torque - sin(angle)}
initial_state: {values: {angle: 0}}
phases: [{knots: 40, dt: 0.1}]
costs: {effort: {residual: control, weight: 0.02}}
terminal:
  costs:
)";

/// A problem of a text, solved.
class Solved {
 public:
  explicit Solved(const std::string& text, std::vector<std::string> arguments = {}) {
    const std::string file = folder_.path() / "problem.yaml";
    std::ofstream(file) << text;
    arguments.insert(arguments.begin(), {"solve", file, "-o", folder_.path() / "out"});
    run = run_conddp(arguments);
    document = Json::parse(read_file(solution()));
  }

  std::string solution() const { return folder_.path() / "out/solution.json"; }
  double cost() const { return document.at("cost"); }
  std::string verdict() const { return document.at("certificate").at("verdict"); }

  ProcessResult run;
  Json document;

 private:
  TemporaryFolder folder_;
};

// The height of the tip: at rest its slope by the torque vanishes.
TEST(Verdicts, ASwingUpFromRestLeavesTheSaddle) {
  const Solved swing(kHanging +
                     "    tip: {residual: expression, rows: {x: sin(angle), z: -cos(angle)}, "
                     "reference: [0, 1], weight: 10}\n");
  EXPECT_EQ(swing.run.exit_code, 0) << swing.run.err;
  EXPECT_EQ(swing.verdict(), "local_minimum");
  EXPECT_LT(swing.cost(), 1) << "at rest 20";
  EXPECT_EQ(run_conddp({"verify", swing.solution(), "--quiet"}).exit_code, 0);
}

// So large a weight that its gradient alone decides what is small.
TEST(Verdicts, WeightsOfGoalsDoNotHideTheEffort) {
  const auto cost = [](const char* weight) {
    const Solved swing(
        kHanging + "    up: {residual: state, reference: {values: {angle: 3}}, weight: " + weight +
        "}\n");
    EXPECT_EQ(swing.run.exit_code, 0) << swing.run.err;
    EXPECT_EQ(swing.verdict(), "local_minimum");
    return swing.cost();
  };
  const double usual = cost("1e4");
  EXPECT_NEAR(cost("1e7"), usual, 1e-3 * usual);
  EXPECT_NEAR(cost("1e10"), usual, 1e-3 * usual);
}

TEST(Verdicts, AGoalSmallerThanItsToleranceIsReached) {
  const Solved stage(R"(conddp: 1
name: stage
system: {states: [x], controls: [v], rate: {x: v}}
initial_state: {values: {x: 0}}
phases: [{knots: 10, duration: 1}]
costs: {effort: {residual: control}}
terminal: {constraints: {there: {residual: state, reference: [2.0e-7]}}}
)");
  EXPECT_EQ(stage.run.exit_code, 0) << stage.run.err;
  EXPECT_NEAR(stage.cost(), 2e-14, 2e-20);
  EXPECT_EQ(stage.verdict(), "local_minimum");
}

// The answer moved back to where it began: all that it says is true, and there is a way down.
TEST(Verdicts, AMotionThatCostsMoreIsNotVerified) {
  const Solved stage(R"(conddp: 1
name: flat
system: {states: [x], controls: [v], next: {x: x + v}}
initial_state: {values: {x: 0}}
phases: [{knots: 2, dt: 1}]
costs: {effort: {residual: control, weight: 1.0e-3}}
terminal: {constraints: {there: {residual: state, reference: [1.0e-3]}}}
)");
  ASSERT_EQ(stage.run.exit_code, 0) << stage.run.err;
  Json forged = stage.document;
  forged.erase("certificate");
  const double early = 0.9e-3, late = 0.1e-3;
  forged["trajectory"]["u"] = {{early}, {late}};
  forged["trajectory"]["x"][1] = {early};
  forged["trajectory"]["x"][2] = {early + late};
  const double cost = 0.5e-3 * (early * early + late * late);
  forged["cost"] = forged["cost_by_name"]["effort"] = cost;
  forged["log"].back()["cost"] = cost;
  std::ofstream(stage.solution()) << forged.dump();
  const ProcessResult verified = run_conddp({"verify", stage.solution()});
  EXPECT_EQ(verified.exit_code, 1);
  EXPECT_NE(verified.out.find("would gain or repair"), std::string::npos) << verified.out;
}

}  // namespace
}  // namespace conddp
