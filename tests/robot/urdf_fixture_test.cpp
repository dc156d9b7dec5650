#include <algorithm>
#include <fstream>

#include <Eigen/Core>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "robot/urdf/urdf.hpp"
#include "support/robots.hpp"
#include "support/simple_kinematics.hpp"

namespace conddp {
namespace {

using nlohmann::json;

RobotModel load_checked(const TestRobot& robot) {
  UrdfOptions options;
  options.base = robot.base;
  UrdfResult result = load_urdf(robot.urdf, options);
  for (const UrdfProblem& problem : result.problems)
    if (!problem.warning) ADD_FAILURE() << robot.name << ": " << problem.message;
  if (!result.model) throw std::runtime_error(robot.name + " does not load");
  return std::move(*result.model);
}

void expect_same_joints(const RobotModel& model, const json& fixture) {
  ASSERT_EQ(model.nq, fixture["nq"].get<int>());
  ASSERT_EQ(model.nv, fixture["nv"].get<int>());
  ASSERT_EQ(model.joints.size(), fixture["joints"].size());
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const std::string name = fixture["joints"][i];
    EXPECT_EQ(model.joints[i].name, name == "root_joint" ? "base" : name);
  }
  const double mass = fixture["mass"];
  EXPECT_NEAR(model.total_mass(), mass, 1e-12 * mass);
}

void expect_same_sample(const RobotModel& model, const json& sample) {
  const std::vector<double> q = sample["q"];
  for (const auto& [link, expected] : sample["frames"].items()) {
    const SE3<double> frame = simple_frame_placement(model, q, link);
    for (int i = 0; i < 9; ++i)
      EXPECT_NEAR(frame.R.m[i], expected["R"][i].get<double>(), 1e-13) << link;
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(frame.p[i], expected["p"][i].get<double>(), 1e-13) << link;
  }
  const Vector3<double> com = simple_com(model, q);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(com[i], sample["com"][i].get<double>(), 1e-13);
  const std::vector<double> flat = sample["M"];
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
      expected(flat.data(), model.nv, model.nv);
  EXPECT_LT((simple_inertia_matrix(model, q) - expected).cwiseAbs().maxCoeff(),
            1e-13 * expected.cwiseAbs().maxCoeff());
}

void expect_same_as_pinocchio(const TestRobot& robot) {
  SCOPED_TRACE(robot.name);
  std::ifstream file(fixture_path(robot));
  ASSERT_TRUE(file) << "no fixture: run scripts/peers/robot_fixtures.py";
  const json fixture = json::parse(file);
  const RobotModel model = load_checked(robot);
  expect_same_joints(model, fixture);
  for (const json& sample : fixture["samples"]) expect_same_sample(model, sample);
}

TEST(UrdfAgainstPinocchio, OwnRobotsMatchOrderPlacementsAndInertia) {
  for (const TestRobot& robot : our_robots()) expect_same_as_pinocchio(robot);
}

TEST(UrdfAgainstPinocchio, ForeignRobotsMatchOrderPlacementsAndInertia) {
  const std::vector<TestRobot> robots = foreign_robots();
  if (robots.empty()) GTEST_SKIP() << kNoForeignRobots;
  for (const TestRobot& robot : robots)
    if (std::filesystem::exists(fixture_path(robot))) expect_same_as_pinocchio(robot);
}

TEST(ForeignRobots, AllLoadAndDoubtfulInertiasAreWarnings) {
  const std::vector<TestRobot> robots = foreign_robots();
  if (robots.empty()) GTEST_SKIP() << kNoForeignRobots;
  for (const TestRobot& robot : robots) {
    UrdfOptions options;
    options.base = robot.base;
    const UrdfResult result = load_urdf(robot.urdf, options);
    EXPECT_TRUE(result.model) << robot.name;
    const bool doubtful =
        std::any_of(result.problems.begin(), result.problems.end(), [](const UrdfProblem& problem) {
          return problem.warning && problem.message.find("used as given") != std::string::npos;
        });
    EXPECT_EQ(doubtful,
              robot.name == "hyq" || robot.name == "anymal_b" || robot.name == "talos_reduced")
        << robot.name;
  }
}

TEST(OurRobots, LoadWithoutWarnings) {
  for (const TestRobot& robot : our_robots()) {
    UrdfOptions options;
    options.base = robot.base;
    const UrdfResult result = load_urdf(robot.urdf, options);
    ASSERT_TRUE(result.model) << robot.name;
    EXPECT_TRUE(result.problems.empty()) << robot.name << ": " << result.problems[0].message;
  }
}

TEST(OurRobots, CartPoleMatchesTheTextbook) {
  const RobotModel model = load_checked(our_robots()[0]);
  ASSERT_EQ(model.nv, 2);
  EXPECT_EQ(model.joints[0].name, "slider");
  EXPECT_EQ(model.joints[1].name, "hinge");
  EXPECT_EQ(model.joints[0].max_effort, 10);
  EXPECT_EQ(model.joints[1].max_effort, kUnlimited);
  const double x = 0.3, angle = 2.1;
  const Vector3<double> tip = simple_frame_placement(model, {x, angle}, "tip").p;
  EXPECT_NEAR(tip.x, x + 0.5 * std::sin(angle), 1e-15);
  EXPECT_NEAR(tip.y, 0, 1e-15);
  EXPECT_NEAR(tip.z, -0.5 * std::cos(angle), 1e-15);
  const Eigen::MatrixXd m = simple_inertia_matrix(model, {x, angle});
  EXPECT_NEAR(m(0, 0), 1.2, 1e-15);
  EXPECT_NEAR(m(0, 1), 0.2 * 0.5 * std::cos(angle), 1e-15);
  EXPECT_NEAR(m(1, 1), 0.2 * 0.25, 1e-15);
}

TEST(OurRobots, QuadrupedStandsOnItsFeet) {
  const auto robots = our_robots();
  const auto robot = std::find_if(robots.begin(), robots.end(),
                                  [](const TestRobot& r) { return r.name == "quadruped"; });
  const RobotModel model = load_checked(*robot);
  EXPECT_NEAR(model.total_mass(), 50, 1e-12);
  std::vector<double> q = model.neutral_configuration();
  q[2] = 0.57;
  for (const char* leg : {"LF", "RF", "LH", "RH"}) {
    const double side = leg[1] == 'F' ? 1 : -1;
    q[model.joints[*model.find_joint(leg + std::string("_HAA"))].q] = -0.2;
    q[model.joints[*model.find_joint(leg + std::string("_HFE"))].q] = 0.75 * side;
    q[model.joints[*model.find_joint(leg + std::string("_KFE"))].q] = -1.5 * side;
  }
  for (const char* foot : {"lf_foot", "rf_foot", "lh_foot", "rh_foot"}) {
    const Vector3<double> p = simple_frame_placement(model, q, foot).p;
    EXPECT_NEAR(p.z, 0, 1e-4) << foot;
    EXPECT_NEAR(std::abs(p.x), 0.35, 1e-9) << foot;
    EXPECT_GT(std::abs(p.y), 0.25) << foot;
    EXPECT_EQ(p.y > 0, foot[0] == 'l') << foot;
    EXPECT_EQ(p.x > 0, foot[1] == 'f') << foot;
  }
}

}  // namespace
}  // namespace conddp
