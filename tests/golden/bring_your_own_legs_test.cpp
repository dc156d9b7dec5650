// Legged robots that are not part of the product stand, make a step and stand again, on problem
// files as a user writes them.
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "problem_file/build.hpp"
#include "problem_file/read_problem.hpp"
#include "robot/frames.hpp"
#include "solvers/registry.hpp"
#include "support/robots.hpp"

namespace conddp {
namespace {

struct Step {
  std::string robot;
  std::vector<std::string> feet;  ///< frames; the last one swings
  bool soles = false;
  std::map<std::string, double> posture;  ///< rad, the rest 0
  double length, height;                  ///< m
  int swing_knots;
  double effort_weight, swing_weight;
  double dt = 0.01;  ///< s
};

void PrintTo(const Step& step, std::ostream* out) { *out << step.robot; }

std::string contacts_but_last(const Step& step) {
  std::string names;
  for (std::size_t i = 0; i + 1 < step.feet.size(); ++i)
    names += fmt::format("{}foot_{}", i > 0 ? ", " : "", i);
  return names;
}

std::string problem_text(const Step& step) {
  std::string joints, contacts;
  for (const auto& [name, angle] : step.posture)
    joints += fmt::format("{}{}: {}", joints.empty() ? "" : ", ", name, angle);
  for (std::size_t i = 0; i < step.feet.size(); ++i)
    contacts += fmt::format("  foot_{}: {{frame: {}}}\n", i, step.feet[i]);
  const std::string flat = step.soles
                               ? fmt::format(
                                     "  flat: {{residual: frame_rotation, frame: {}, phases: step, "
                                     "reference: initial, weight: 1.0e+3}}\n",
                                     step.feet.back())
                               : "";
  return fmt::format(R"(conddp: 1
name: step_{0}
robot:
  urdf: {0}.urdf
  base: floating
  configurations: {{standing: {{joints: {{{1}}}}}}}
contacts:
  defaults: {{{2}, friction: 0.7, baumgarte: {{kd: 100}}}}
{3}initial_state: {{configuration: standing}}
phases:
  - {{name: stand, duration: 0.4, knots: {13}, contacts: all}}
  - {{name: step, knots: {4}, dt: {14}, contacts: [{5}]}}
  - {{name: settle, duration: 0.4, knots: {13}, contacts: all}}
costs:
  posture: {{residual: state, reference: standing, weight: 1,
            weights: {{"base/x": 0, "base/y": 0.1, "base/z": 10, "base/r*": 10, "q/*": 0.1,
                      "base/v*": 0.1, "base/w*": 0.1, "v/*": 0.01}}}}
  effort: {{residual: control, weight: {6}}}
  cone: {{residual: {7}, contacts: all, weight: 1}}
  swing: {{residual: frame_position, frame: {8}, phases: step, weight: {12},
          swing: {{height: {9}, step: [{10}, 0, 0]}}}}
{11}constraints:
  torque: {{bounds: control, from: urdf}}
terminal:
  costs:
    rest: {{residual: state, reference: standing, weight: 10,
           weights: {{"base/x": 0, "base/r*": 10, "v/*": 0.1}}}}
initial_guess: {{states: initial, controls: quasi_static}}
solver: {{name: box_fddp, max_iterations: 300}}
)",
                     step.robot, joints,
                     step.soles ? "type: surface, size: [0.2, 0.1]" : "type: point", contacts,
                     step.swing_knots, contacts_but_last(step), step.effort_weight,
                     step.soles ? "wrench_cone" : "friction_cone", step.feet.back(), step.height,
                     step.length, flat, step.swing_weight, std::lround(0.4 / step.dt), step.dt);
}

class BringYourOwnLegs : public testing::TestWithParam<Step> {};

TEST_P(BringYourOwnLegs, StandMakeAStepAndStandAgain) {
  const Step& step = GetParam();
  const auto folder = foreign_robot_folder();
  if (!std::filesystem::exists(folder / (step.robot + ".urdf"))) GTEST_SKIP() << kNoForeignRobots;
  Diagnostics diagnostics;
  const auto spec = read_problem_text(problem_text(step), folder / "step.yaml", {}, diagnostics);
  ASSERT_TRUE(spec) << format_diagnostics(diagnostics, false);
  const auto built = build_problem(*spec, {}, diagnostics);
  ASSERT_TRUE(built) << format_diagnostics(diagnostics, false);
  const SolveResult result = solve(*built->problem, "box_fddp", spec->solver.options, built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_LE(result.residuals.gap, 1e-9);
  EXPECT_EQ(result.residuals.constraint, 0);

  const RobotModel& robot = built->plant.robot();
  const auto position = [&](int k, const std::string& frame) {
    RobotData<double> data(robot);
    update_placements(robot, result.trajectory.x(k).data(), data);
    return frame_placement(robot, data, *robot.find_frame(frame)).p;
  };
  const int N = built->problem->knots();
  const Vector3<double> start = position(0, step.feet.back()), end = position(N, step.feet.back());
  EXPECT_NEAR(end.x - start.x, step.length, 0.2 * step.length);
  double highest = 0;
  for (int k = 0; k <= N; ++k)
    highest = std::max(highest, position(k, step.feet.back()).z - start.z);
  EXPECT_GT(highest, 0.8 * step.height);
  for (std::size_t i = 0; i + 1 < step.feet.size(); ++i) {
    const Vector3<double> slip = position(N, step.feet[i]) - position(0, step.feet[i]);
    // Contacts are held on the level of accelerations: their drift is of first order in the step.
    EXPECT_LT(std::sqrt(squared_norm(slip)), 0.5 * step.dt) << step.feet[i];
  }
}

/// Angles of legs that are mirrored left to right (`out`) and front to hind (the others).
std::map<std::string, double> four_legs(const std::vector<std::string>& prefixes, bool mirrored,
                                        const std::array<std::string, 3>& joints,
                                        const std::array<double, 3>& angles) {
  std::map<std::string, double> posture;
  for (std::size_t leg = 0; leg < prefixes.size(); ++leg) {
    const double side = mirrored && leg % 2 == 1 ? -1 : 1, end = leg < 2 ? 1 : -1;
    posture[prefixes[leg] + joints[0]] = side * angles[0];
    posture[prefixes[leg] + joints[1]] = end * angles[1];
    posture[prefixes[leg] + joints[2]] = end * angles[2];
  }
  return posture;
}

std::vector<Step> steps() {
  return {{"hyq",
           {"lf_foot", "lh_foot", "rh_foot", "rf_foot"},
           false,
           four_legs({"lf_", "rf_", "lh_", "rh_"}, false, {"haa_joint", "hfe_joint", "kfe_joint"},
                     {-0.2, 0.75, -1.5}),
           0.1,
           0.05,
           15,
           1e-3,
           1e5},
          {"anymal_b",
           {"LF_FOOT", "LH_FOOT", "RH_FOOT", "RF_FOOT"},
           false,
           four_legs({"LF_", "RF_", "LH_", "RH_"}, true, {"HAA", "HFE", "KFE"}, {-0.1, 0.7, -1.0}),
           0.1,
           0.05,
           15,
           1e-3,
           1e5},
          {"solo12",
           {"FL_FOOT", "HL_FOOT", "HR_FOOT", "FR_FOOT"},
           false,
           four_legs({"FL_", "FR_", "HL_", "HR_"}, true, {"HAA", "HFE", "KFE"}, {0.1, 0.8, -1.6}),
           0.05,
           0.04,
           15,
           1e-2,
           1e5},
          {"bolt",
           {"FL_FOOT", "FR_FOOT"},
           false,
           {{"FL_HFE", 0.8}, {"FL_KFE", -1.6}, {"FR_HFE", 0.8}, {"FR_KFE", -1.6}},
           0.05,
           0.04,
           8,
           1e-2,
           1e5},
          {"talos_reduced",
           {"left_sole_link", "right_sole_link"},
           true,
           {{"leg_left_3_joint", -0.411354},
            {"leg_left_4_joint", 0.859395},
            {"leg_left_5_joint", -0.448041},
            {"leg_right_3_joint", -0.411354},
            {"leg_right_4_joint", 0.859395},
            {"leg_right_5_joint", -0.448041},
            {"arm_left_1_joint", 0.25847},
            {"arm_left_2_joint", 0.173046},
            {"arm_left_4_joint", -0.525366},
            {"arm_right_1_joint", -0.25847},
            {"arm_right_2_joint", -0.173046},
            {"arm_right_4_joint", -0.525366}},
           0.1,
           0.05,
           15,
           1e-3,
           1e4,
           0.02}};
}

INSTANTIATE_TEST_SUITE_P(Robots, BringYourOwnLegs, testing::ValuesIn(steps()),
                         [](const auto& test) { return test.param.robot; });

}  // namespace
}  // namespace conddp
