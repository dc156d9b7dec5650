// The planar hopper of the examples, upright or bent, with optional motors, springs, and limits.
#include "analysis/findings/holding_torques.hpp"

#include <gtest/gtest.h>

#include "analysis/findings/diagnosis.hpp"
#include "robot/urdf/urdf.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/small_problems.hpp"
#include "support/source_tree.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

using Base = UrdfOptions::Base;

struct Leg {
  Base base = Base::planar;
  std::vector<std::string> motors = {"hip", "knee"};
  std::optional<ContactKind> foot = ContactKind::surface;
  double limit = testing::kFree;  ///< of all motors, Nm
  double speed = 0;               ///< of the knee, rad/s
  int feet = 1;                   ///< contacts at the foot
};

ShootingProblem problem_of(const Leg& leg) {
  const UrdfResult urdf =
      load_urdf(source_tree() / "problems/robots/hopper.urdf",
                {.base = leg.base,
                 .placement = SE3<double>{rotation_matrix(exp_so3(Vector3<double>{M_PI / 2, 0, 0})),
                                          Vector3<double>::zero()}});
  const auto robot = std::make_shared<const RobotModel>(urdf.model.value());
  std::vector<Contact> contacts;
  for (int i = 0; leg.foot && i < leg.feet; ++i)
    contacts.push_back({.name = "foot" + std::to_string(i),
                        .frame = *robot->find_frame("foot"),
                        .kind = *leg.foot});
  const auto system = std::make_shared<MultibodySystem>(
      robot, Actuation::joints(*robot, leg.motors), PassiveForces{}, contacts);
  std::vector<double> start(system->nx(), 0.0);
  start[system->nq() - 2] = 0.5;
  start[system->nq() - 1] = -1;
  start.back() = leg.speed;
  const std::vector<double> ones(start.size(), 1), motors(leg.motors.size(), 1e-4);
  return testing::tracking_problem(system, Integrator::semi_implicit_euler, 20, 0.02, start,
                                   {.goal = start, .q = ones, .r = motors, .qf = ones}, -leg.limit,
                                   leg.limit);
}

/// "knee", or "" if no torque is missing.
std::string weak_joint(const Leg& leg) {
  const auto lack = missing_torque(problem_of(leg));
  return lack ? lack->joint : "";
}

// The knee carries the body, 9 kg, at a lever arm of 0.3 m sin 0.5 = 14 cm, and most of the thigh.
TEST(MissingTorque, MatchesKneeTorqueOfBentLeg) {
  EXPECT_EQ(weak_joint({.limit = 30}), "");
  const auto weak = missing_torque(problem_of({.limit = 2}));
  ASSERT_TRUE(weak);
  EXPECT_EQ(weak->joint, "knee");
  EXPECT_EQ(weak->unit, "Nm");
  EXPECT_TRUE(weak->driven);
  EXPECT_NEAR(weak->needed, 9.81 * (9 * 0.3 + 1.8 * 0.18) * std::sin(0.5), 0.1);
  EXPECT_EQ(weak->limit, 2);
}

// Models a leaf spring or a closed-chain rod that the file describes as a passive joint.
TEST(MissingTorque, CoversUndrivenJoints) {
  for (const double limit : {testing::kFree, 90.0}) {
    const auto loose = missing_torque(problem_of({.motors = {"hip"}, .limit = limit}));
    ASSERT_TRUE(loose);
    EXPECT_EQ(loose->joint, "knee");
    EXPECT_FALSE(loose->driven);
    EXPECT_EQ(loose->limit, 0);
  }
}

// A foot held twice: the load split between its contacts is ambiguous.
TEST(MissingTorque, IsFoundForDependentContacts) {
  EXPECT_EQ(weak_joint({.limit = 30, .feet = 2}), "");
  EXPECT_EQ(weak_joint({.limit = 2, .feet = 2}), "knee");
}

TEST(MissingTorque, IgnoresRobotsThatFallTipOrMove) {
  EXPECT_EQ(weak_joint({.foot = std::nullopt, .limit = 2}), "");
  EXPECT_EQ(weak_joint({.limit = 2, .speed = 1}), "");
  // Support at one point only: no torque keeps the body upright if its center is beside the foot.
  EXPECT_EQ(weak_joint({.foot = ContactKind::point, .limit = 90}), "");
}

TEST(MissingTorque, CoversBoltedArmsWithAllJointsDriven) {
  const Leg arm{.base = Base::fixed, .foot = std::nullopt, .limit = 0.2};
  EXPECT_NE(weak_joint(arm), "");
  Leg strong = arm;
  strong.limit = 30;
  EXPECT_EQ(weak_joint(strong), "");
  Leg pendulum = arm;
  pendulum.motors = {"hip"};
  EXPECT_EQ(weak_joint(pendulum), "");
}

TEST(MissingTorque, ExplainsSolvesThatEndWithoutAnAnswer) {
  const auto diagnosis = [](const Leg& leg) {
    const ShootingProblem problem = problem_of(leg);
    const SolverOptions options{.max_iterations = 2};
    const SolveResult result =
        solve(problem, "box_fddp", options, testing::constant_controls(problem, 0.1));
    EXPECT_EQ(result.status, SolveStatus::max_iterations);
    return diagnose(problem, result, options);
  };
  const Diagnosis weak = diagnosis({.limit = 2});
  EXPECT_EQ(weak.pattern, DiagnosisPattern::no_static_equilibrium);
  EXPECT_NE(weak.message.find("'knee' would need"), std::string::npos) << weak.message;
  EXPECT_NE(weak.message.find("its limit is"), std::string::npos) << weak.message;
  EXPECT_NE(weak.remedy.find("more iterations"), std::string::npos) << weak.remedy;
  const Diagnosis loose = diagnosis({.motors = {"hip"}});
  EXPECT_NE(loose.message.find("it has no control"), std::string::npos) << loose.message;
}

}  // namespace
}  // namespace conddp
