#include <algorithm>
#include <cmath>

#include "output/scene/motion_scene.hpp"
#include "report_fixture.hpp"

namespace conddp {
namespace {

constexpr double kTight = 1e-7;  // numbers of scenes have eight digits

/// The scene of a problem's first guess.
OrderedJson scene_of(const BuiltProblem& built) { return motion_scene(built, built.guess); }

TEST_F(Report, DrawsOwnEquationsInThePlane) {
  load("collection/around_a_disc.yaml",
       {"draw={boat: {box: {size: [0.3, 0.1, 0.1]}, at: [x, y], angle: direction}, rope: {line: "
        "[[0, 0], [x, y]]}, rock: {sphere: {radius: 1}}}"});
  const OrderedJson scene = scene_of(*built_);
  EXPECT_EQ(scene["planar"], true);
  EXPECT_EQ(scene["bodies"][1]["name"], "boat");
  EXPECT_EQ(scene["bodies"][1]["shapes"][0]["points"].size(), 8u);
  EXPECT_EQ(named(scene["obstacles"], "rock")["scenery"], true);
  const int nodes = built_->problem->knots() + 1;
  const auto count = static_cast<std::size_t>(nodes);
  ASSERT_EQ(scene["poses"].size(), 14 * count);
  ASSERT_EQ(scene["paths"]["boat"].size(), 3 * count);
  ASSERT_EQ(scene["lines"][0]["positions"].size(), 6 * count);
  for (int k = 0; k < nodes; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const auto x = built_->guess.x(k);
    EXPECT_NEAR(scene["poses"][14 * at + 7].get<double>(), x[0], kTight);
    EXPECT_NEAR(scene["lines"][0]["positions"][6 * at + 4].get<double>(), x[1], kTight);
    // The choice of the duration and the last node have the controls of their neighbors.
    const double direction = built_->guess.u(std::clamp(k, 1, nodes - 2))[0];
    EXPECT_NEAR(scene["poses"][14 * at + 12].get<double>(), std::sin(direction / 2), kTight);
  }
}

TEST_F(Report, DrawsBesidesRobotsAndBuiltInPictures) {
  load("cartpole_swingup.yaml",
       {"draw={flag: {capsule: {radius: 0.01, to: [0, 0, 0.3]}, at: [1, 0, 0]}}"});
  const OrderedJson robot = scene_of(*built_);
  EXPECT_EQ(robot["planar"], false);
  EXPECT_EQ(robot["bodies"].back()["name"], "flag");
  EXPECT_FALSE(robot["paths"].contains("flag")) << "it is at rest";
  const std::size_t bodies = robot["bodies"].size();
  EXPECT_EQ(robot["poses"].size(), 7 * bodies * (built_->problem->knots() + 1));
  EXPECT_EQ(robot["poses"][7 * bodies - 7], 1.0);

  load("unicycle_obstacles.yaml", {"draw={goal: {at: [3, 3]}}"});
  const OrderedJson unicycle = scene_of(*built_);
  EXPECT_EQ(unicycle["bodies"][1]["name"], "unicycle");
  EXPECT_EQ(unicycle["bodies"][2]["shapes"][0]["kind"], "dot");
  EXPECT_EQ(unicycle["planar"], false) << "the unicycle has a height";
}

TEST_F(Report, PosesTurnAboutTheirOwnAxis) {
  load("cartpole_swingup.yaml",
       {"draw={tool: {sphere: {radius: 0.1}, at: [1, 2, 3, 1, 0, 0, 0], angle: 1}}"});
  const OrderedJson scene = scene_of(*built_);
  const std::size_t last = 7 * scene["bodies"].size() - 7;
  // Half a turn about x, then 1 rad about the turned z axis.
  const double expected[] = {1, 2, 3, std::cos(0.5), -std::sin(0.5), 0, 0};
  for (std::size_t i = 0; i < 7; ++i)
    EXPECT_NEAR(scene["poses"][last + i].get<double>(), expected[i], kTight) << i;
}

TEST_F(Report, DrawingsStayOutsideTheirPhases) {
  load("rocket_stages.yaml", {"draw={stage: {at: [0, h], phases: boost}, rest: {at: [1, h]}}"});
  Trajectory motion = built_->guess;
  for (int k = 0; k <= motion.knots(); ++k) motion.x(k)[0] = k;
  const OrderedJson scene = motion_scene(*built_, motion);
  const auto height = [&](int k, int body) {
    return scene["poses"][static_cast<std::size_t>(21 * k + 7 * body + 1)].get<double>();
  };
  EXPECT_EQ(height(20, 1), 20);
  EXPECT_EQ(height(60, 1), height(40, 1));
  EXPECT_EQ(height(60, 2), 60);
}

}  // namespace
}  // namespace conddp
