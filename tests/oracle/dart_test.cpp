#include <optional>
#include <ostream>

#include <gtest/gtest.h>

#include "oracle/dart_robot.hpp"
#include "robot/dynamics.hpp"
#include "robot/frames.hpp"
#include "support/random_robot.hpp"

// Rigid-body quantities in random states, compared with DART on the same files.

namespace conddp {

// GoogleTest prints a parameter with this.
void PrintTo(const TestRobot& robot, std::ostream* out) { *out << robot.name; }

namespace {

constexpr double kTolerance = 1e-10;
constexpr int kStates = 5;

std::vector<TestRobot> all_robots() {
  std::vector<TestRobot> robots = our_robots();
  for (const TestRobot& robot : foreign_robots()) robots.push_back(robot);
  return robots;
}

/// Relative to the largest element, at least 1.
void expect_close(const Eigen::MatrixXd& ours, const Eigen::MatrixXd& theirs, const char* what) {
  ASSERT_EQ(ours.rows(), theirs.rows()) << what;
  ASSERT_EQ(ours.cols(), theirs.cols()) << what;
  const double scale = std::max(1.0, theirs.cwiseAbs().maxCoeff());
  EXPECT_LE((ours - theirs).cwiseAbs().maxCoeff(), kTolerance * scale) << what << ", ours:\n"
                                                                       << ours << "\ntheirs:\n"
                                                                       << theirs;
}

Eigen::Map<const Eigen::VectorXd> as_vector(const AlignedVector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}
Eigen::VectorXd as_vector(const Motion<double>& m) {
  Eigen::VectorXd r(6);
  for (int i = 0; i < 6; ++i) r[i] = m[i];
  return r;
}

class Dart : public testing::TestWithParam<TestRobot> {
 protected:
  void SetUp() override {
    UrdfResult result = load_urdf(GetParam().urdf, {.base = GetParam().base});
    ASSERT_TRUE(result.model) << GetParam().urdf;
    model_ = std::move(*result.model);
    dart_.emplace(GetParam(), model_);
    data_.emplace(model_);
  }

  template <class F>
  void in_random_states(F test) {
    RandomNumbers random(1);
    for (int i = 0; i < kStates; ++i) {
      const RobotState x = random_state(model_, random);
      dart_->set_state(x.q, x.v);
      test(x);
    }
  }

  RobotModel model_;
  std::optional<DartRobot> dart_;
  std::optional<RobotData<double>> data_;
};

TEST_P(Dart, InertiaMatrix) {
  in_random_states([&](const RobotState& x) {
    update_placements(model_, x.q.data(), *data_);
    mass_matrix(model_, *data_);
    const Eigen::MatrixXd lower =
        Eigen::Map<const Eigen::MatrixXd>(data_->M.data(), model_.nv, model_.nv);
    expect_close(lower.selfadjointView<Eigen::Lower>(), dart_->mass_matrix(), "M");
  });
}

TEST_P(Dart, BiasForces) {
  in_random_states([&](const RobotState& x) {
    update_placements(model_, x.q.data(), *data_);
    update_velocities(model_, x.v.data(), *data_);
    update_composite_inertias(model_, *data_);
    bias_forces(model_, x.v.data(), *data_);
    expect_close(as_vector(data_->bias), dart_->bias(), "bias");
  });
}

TEST_P(Dart, ForwardDynamics) {
  in_random_states([&](const RobotState& x) {
    const Eigen::VectorXd theirs = dart_->forward_dynamics(x.tau);
    forward_dynamics(model_, x.q.data(), x.v.data(), x.tau.data(), *data_);
    expect_close(as_vector(data_->acceleration), theirs, "factorisation");
  });
}

TEST_P(Dart, LinkPlacementsVelocitiesAndAccelerations) {
  in_random_states([&](const RobotState& x) {
    dart_->set_accelerations(x.a);
    update_placements(model_, x.q.data(), *data_);
    update_velocities(model_, x.v.data(), *data_);
    update_accelerations(model_, x.v.data(), x.a.data(), *data_);
    for (const std::string& link : dart_->links()) {
      const std::optional<int> frame = model_.find_frame(link);
      ASSERT_TRUE(frame) << link;
      const SE3<double> ours = frame_placement(model_, *data_, *frame);
      const Eigen::Isometry3d theirs = dart_->placement(link);
      expect_close(Eigen::Map<const Eigen::Matrix3d>(ours.R.m).transpose(), theirs.linear(),
                   link.c_str());
      expect_close(Eigen::Vector3d(ours.p.x, ours.p.y, ours.p.z), theirs.translation(),
                   link.c_str());
      expect_close(as_vector(frame_velocity(model_, *data_, *frame, FrameAxes::local)),
                   dart_->velocity(link), link.c_str());
      expect_close(as_vector(frame_acceleration(model_, *data_, *frame, FrameAxes::local)),
                   dart_->acceleration(link), link.c_str());
    }
  });
}

TEST_P(Dart, CenterOfMass) {
  in_random_states([&](const RobotState& x) {
    update_placements(model_, x.q.data(), *data_);
    update_composite_inertias(model_, *data_);
    const Vector3<double> com = center_of_mass(model_, *data_);
    expect_close(Eigen::Vector3d(com.x, com.y, com.z), dart_->center_of_mass(), "com");
  });
}

INSTANTIATE_TEST_SUITE_P(AllRobots, Dart, testing::ValuesIn(all_robots()),
                         [](const auto& suite) { return suite.param.name; });

TEST(DartRobots, IncludeEightRobotsAndFourFloatingOnes) {
  const std::vector<TestRobot> robots = all_robots();
  if (robots.size() == our_robots().size()) GTEST_SKIP() << kNoForeignRobots;
  int floating = 0;
  for (const TestRobot& robot : robots) floating += robot.base == UrdfOptions::Base::floating;
  EXPECT_GE(robots.size(), 8u);
  EXPECT_GE(floating, 4);
}

}  // namespace
}  // namespace conddp
