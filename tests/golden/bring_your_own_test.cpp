// Arms from outside the product, using problem files in the style of a user.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "robot/frames.hpp"
#include "robot/kinematics.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/robots.hpp"

namespace conddp {
namespace {

struct Reach {
  std::string robot;
  std::string frame;
  std::vector<std::string> locked;
  std::vector<double> start, goal;  ///< rad; the frame's pose there is the goal pose
  double step;                      ///< s, 100 steps: short enough to saturate an actuator
};

void PrintTo(const Reach& reach, std::ostream* out) { *out << reach.robot; }

std::string pose_text(const RobotModel& model, const std::string& frame,
                      const std::vector<double>& q) {
  RobotData<double> data(model);
  update_placements(model, q.data(), data);
  const SE3<double> m = frame_placement(model, data, *model.find_frame(frame));
  const Quaternion<double> r = quaternion(m.R);
  return fmt::format("{{position: [{}, {}, {}], orientation: [{}, {}, {}, {}]}}", m.p.x, m.p.y,
                     m.p.z, r.x, r.y, r.z, r.w);
}

std::string problem_text(const Reach& reach, const RobotModel& model) {
  std::string joints, locked;
  for (int i = 0; i < model.joint_count(); ++i)
    joints += fmt::format("{}{}: {}", i ? ", " : "", model.joints[i].name, reach.start[i]);
  for (const std::string& name : reach.locked)
    locked += fmt::format("{}{}: 0.02", locked.empty() ? "" : ", ", name);
  return fmt::format(R"(conddp: 1
name: reach_{0}
robot: {{urdf: {0}.urdf, base: fixed{1}}}
initial_state: {{joints: {{{2}}}}}
integrator: semi_implicit_euler
phases: [{{name: move, knots: 100, dt: {3}}}]
costs:
  effort: {{residual: control_gravity, weight: 1.0e-4}}
  calm: {{residual: joint_velocity, weight: 1.0e-3}}
constraints:
  torque: {{bounds: control, from: urdf}}
terminal:
  costs:
    hand: {{residual: frame_placement, frame: {4}, weight: 1.0e+5, reference: {5}}}
    rest: {{residual: joint_velocity, weight: 10}}
initial_guess: {{states: initial, controls: quasi_static}}
solver: {{name: box_fddp}}
)",
                     reach.robot, locked.empty() ? "" : ", locked_joints: {" + locked + "}", joints,
                     reach.step, reach.frame, pose_text(model, reach.frame, reach.goal));
}

class BringYourOwn : public ::testing::TestWithParam<Reach> {};

TEST_P(BringYourOwn, HandReachesItsPoseAtTheTorqueLimit) {
  const Reach& reach = GetParam();
  const auto folder = foreign_robot_folder();
  const auto urdf = folder / (reach.robot + ".urdf");
  if (!std::filesystem::exists(urdf)) GTEST_SKIP() << kNoForeignRobots;
  UrdfOptions options;
  for (const std::string& name : reach.locked) options.locked_joints[name] = 0.02;
  const UrdfResult loaded = load_urdf(urdf, options);
  ASSERT_TRUE(loaded.model);
  const RobotModel& model = *loaded.model;

  Diagnostics diagnostics;
  const auto spec =
      read_problem_text(problem_text(reach, model), folder / "reach.yaml", {}, diagnostics);
  ASSERT_TRUE(spec) << problem_text(reach, model);
  const auto built = build_problem(*spec, {}, diagnostics);
  ASSERT_TRUE(built);
  const SolveResult result = solve(*built->problem, "box_fddp", spec->solver.options, built->guess);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;

  RobotData<double> data(model);
  const auto position = [&](const double* q) {
    update_placements(model, q, data);
    return frame_placement(model, data, *model.find_frame(reach.frame)).p;
  };
  const Vector3<double> miss =
      position(result.trajectory.x(100).data()) - position(reach.goal.data());
  EXPECT_LT(std::sqrt(squared_norm(miss)), 1e-3);
  int active = 0;
  for (int k = 0; k < 100; ++k)
    for (int i = 0; i < model.nv; ++i) {
      const double limit = model.joints[i].max_effort;
      EXPECT_LE(std::abs(result.trajectory.u(k)[i]), limit);
      active += std::abs(result.trajectory.u(k)[i]) == limit;
    }
  EXPECT_GT(active, 0);
}

INSTANTIATE_TEST_SUITE_P(Arms, BringYourOwn,
                         ::testing::Values(Reach{"panda",
                                                 "panda_hand",
                                                 {"panda_finger_joint1", "panda_finger_joint2"},
                                                 {0, -0.3, 0, -2, 0, 1.7, 0.8},
                                                 {0.8, 0.3, -0.2, -1.4, 0.4, 1.9, 0.2},
                                                 0.0025},
                                           Reach{"ur5",
                                                 "tool0",
                                                 {},
                                                 {0, -1.2, 1.5, -0.3, 1.5, 0},
                                                 {1.0, -0.8, 1.0, 0.4, 1.0, 0.7},
                                                 0.0025},
                                           Reach{"kinova",
                                                 "j2s6s200_end_effector",
                                                 {},
                                                 {0, 2.9, 1.5, 0, 1.8, 0},
                                                 {1.0, 2.4, 2.2, 0.8, 2.4, 0.6},
                                                 0.0015}),
                         [](const auto& arm) { return arm.param.robot; });

}  // namespace
}  // namespace conddp
