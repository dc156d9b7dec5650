// Legged robots from outside the product stand, take a step, and stand again, using problem files
// in legs/ in the style of a user.
#include <cmath>

#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "robot/frames.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/robots.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

using Data = MultibodySystem::Data<double>;

class BringYourOwnLegs : public ::testing::TestWithParam<std::string> {};

TEST_P(BringYourOwnLegs, StandStepAndStandAgain) {
  const auto urdf = foreign_robot_folder() / (GetParam() + ".urdf");
  if (!std::filesystem::exists(urdf)) GTEST_SKIP() << kNoForeignRobots;
  Diagnostics diagnostics;
  const auto file = source_tree() / "tests/golden/legs" / (GetParam() + ".yaml");
  const auto spec = read_problem(file, {"robot.urdf=" + urdf.string()}, diagnostics);
  ASSERT_TRUE(spec) << format_diagnostics(diagnostics, false);
  const auto built = build_problem(*spec, {}, diagnostics);
  ASSERT_TRUE(built) << format_diagnostics(diagnostics, false);
  const SolveResult result =
      solve(*built->problem, spec->solver.name.value, spec->solver.options, built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_LE(result.residuals.gap, 1e-9);
  EXPECT_EQ(result.residuals.constraint, 0);

  const RobotModel& robot = built->plant.robot();
  const int N = built->problem->knots();
  const auto position = [&](int k, int frame) {
    RobotData<double> data(robot);
    update_placements(robot, result.trajectory.x(k).data(), data);
    return frame_placement(robot, data, frame).p;
  };
  // The swing foot moves as far and as high as the file says.
  const auto& swing = *std::find_if(spec->costs.begin(), spec->costs.end(),
                                    [](const CostSpec& cost) { return cost.keys.has("swing"); });
  const SwingSpec& way = *swing.keys.find(key::swing);
  const int foot = *robot.find_frame(swing.keys.find(key::frame)->value);
  const Vector3<double> start = position(0, foot), end = position(N, foot);
  EXPECT_NEAR(end.x - start.x, way.step->x, 1e-3);
  EXPECT_NEAR(end.y, start.y, 1e-3);
  EXPECT_NEAR(end.z, start.z, 1e-3);
  double highest = 0;
  for (int k = 0; k <= N; ++k) highest = std::max(highest, position(k, foot).z - start.z);
  EXPECT_GT(highest, 0.9 * way.height);

  // No foot slips from its initial contact position, and every foot pushes.
  for (const ContactSpec& contact : spec->contacts) {
    const int frame = *robot.find_frame(contact.frame.value);
    bool standing = false;
    Vector3<double> stood{};
    for (int k = 0; k < N; ++k) {
      const auto& system =
          static_cast<const MultibodySystem&>(built->problem->knot(k).model->system());
      const auto& held = system.contacts().contacts();
      const auto found = std::find_if(
          held.begin(), held.end(), [&](const Contact& c) { return c.name == contact.name.value; });
      if (found != held.end() && !standing) stood = position(k, frame);
      standing = found != held.end();
      if (!standing) continue;
      const Vector3<double> slip = position(k + 1, frame) - stood;
      EXPECT_LT(std::sqrt(squared_norm(slip)), 1e-3) << contact.name.value << " at knot " << k;
      const auto data = system.create_data(double{});
      system.evaluate(result.trajectory.x(k).data(), result.trajectory.u(k).data(), *data);
      const auto& forces = static_cast<const Data&>(*data).contacts.contacts;
      EXPECT_GT(contact_force_in_world(forces[found - held.begin()]).linear.z, 0)
          << contact.name.value << " at knot " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, BringYourOwnLegs,
                         ::testing::Values("hyq", "anymal_b", "solo12", "bolt", "talos_reduced"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace conddp
