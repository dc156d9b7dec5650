#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "robot/urdf/urdf.hpp"
#include "support/mimic_robot.hpp"
#include "systems/multibody/contact_set.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::shared_ptr<const MultibodySystem> system_of(const RobotModel& model) {
  return std::make_shared<MultibodySystem>(std::make_shared<RobotModel>(model),
                                           Actuation::full(model), PassiveForces{true, true, 0.4});
}

/// System state for a robot's full state.
std::vector<double> state_of(const MultibodySystem& system, const RobotState& state) {
  std::vector<double> x = system.reduce_configuration(state.q);
  const std::vector<double> v = system.reduce_velocity(state.v);
  x.insert(x.end(), v.begin(), v.end());
  return x;
}

std::vector<double> random_controls(int n, RandomNumbers& random) {
  std::vector<double> u(n);
  for (double& a : u) a = random.uniform(-10, 10);
  return u;
}

/// Passive forces on all joints, computed independently.
VectorXd passive_forces(const RobotModel& model, const std::vector<double>& v) {
  VectorXd force = VectorXd::Zero(model.nv);
  for (const Joint& joint : model.joints)
    if (joint.type != JointType::floating)
      force[joint.v] = -joint.damping * v[joint.v] - joint.friction * std::tanh(v[joint.v] / 0.4);
  return force;
}

MatrixXd full_mass_matrix(const RobotModel& model, const RobotData<double>& data) {
  return MatrixXd(Map<const MatrixXd>(data.M.data(), model.nv, model.nv))
      .selfadjointView<Eigen::Lower>();
}

TEST(Mimic, AccelerationsMatchRobotWithExplicitConstraints) {
  RandomNumbers random(61);
  for (const auto& [name, model] : mimic_robots()) {
    const auto system = system_of(model);
    const auto data = system->create_data(double{});
    for (int repeat = 0; repeat < 5; ++repeat) {
      const RobotState state = random_mimic_state(model, random);
      const std::vector<double> u = random_controls(system->nu(), random);
      system->evaluate(state_of(*system, state).data(), u.data(), *data);

      // [M, Cᵀ; C, 0] [a; λ] = [τ − bias; 0] with the forces of the full robot.
      RobotData<double> robot(model);
      const Actuation actuation = Actuation::full(model);
      const VectorXd tau = Map<const MatrixXd>(actuation.B.data(), model.nv, actuation.nu) *
                               Map<const VectorXd>(u.data(), actuation.nu) +
                           passive_forces(model, state.v);
      forward_dynamics(model, state.q.data(), state.v.data(), tau.data(), robot);
      const MatrixXd C = mimic_constraints(model);
      const int n = model.nv, m = static_cast<int>(C.rows());
      MatrixXd K = MatrixXd::Zero(n + m, n + m);
      K << full_mass_matrix(model, robot), C.transpose(), C, MatrixXd::Zero(m, m);
      VectorXd right = VectorXd::Zero(n + m);
      right.head(n) = tau - Map<const VectorXd>(robot.bias.data(), n);
      const VectorXd expected = K.fullPivLu().solve(right).head(n);

      const double scale = 1 + expected.lpNorm<Eigen::Infinity>();
      for (int i = 0; i < model.joint_count(); ++i) {
        const auto row = system->velocity_row(i);
        for (int k = 0; row && k < model.joints[i].nv(); ++k)
          EXPECT_NEAR(data->f[*row + k], expected[model.joints[i].v + k], 1e-10 * scale)
              << name << ' ' << model.joints[i].name;
      }
      const auto& own = static_cast<MultibodySystem::Data<double>&>(*data).robot;
      for (int i = 0; i < n; ++i) EXPECT_NEAR(own.acceleration[i], expected[i], 1e-10 * scale);
    }
  }
}

TEST(Mimic, DerivativesMatchDualNumbers) {
  using LaneDual = Dual<Lane>;
  RandomNumbers random(62);
  for (const auto& [name, model] : mimic_robots()) {
    const auto system = system_of(model);
    const auto data = system->create_data(double{});
    const auto dual = system->create_data(LaneDual{});
    const std::vector<double> x = state_of(*system, random_mimic_state(model, random));
    const std::vector<double> u = random_controls(system->nu(), random);
    system->differentiate(x.data(), u.data(), *data);
    const int n = system->nv();
    double scale = 1;
    for (double a : data->fx) scale = std::max(scale, std::abs(a));
    AlignedVector<LaneDual> xd(system->nx()), ud(system->nu()), direction(system->ndx());
    for (int c = 0; c < system->ndx() + system->nu(); ++c) {
      std::copy(x.begin(), x.end(), xd.begin());
      std::copy(u.begin(), u.end(), ud.begin());
      std::fill(direction.begin(), direction.end(), LaneDual(0.0));
      if (c < system->ndx()) {
        direction[c].d = Lane(1.0);
        system->manifold().integrate(xd.data(), direction.data(), xd.data());
      } else {
        ud[c - system->ndx()].d = Lane(1.0);
      }
      system->evaluate(xd.data(), ud.data(), *dual);
      for (int i = 0; i < n; ++i) {
        const double derivative = c < 2 * n ? data->fx[c * n + i] : data->fu[(c - 2 * n) * n + i];
        EXPECT_NEAR(derivative, dual->f[i].d[0], 1e-10 * scale) << name << ' ' << i << ',' << c;
      }
    }
  }
}

TEST(Mimic, EveryLaneMatchesDouble) {
  RandomNumbers random(63);
  for (const auto& [name, model] : mimic_robots()) {
    const auto system = system_of(model);
    const auto lanes = system->create_data(Lane{});
    AlignedVector<Lane> x(system->nx()), u(system->nu());
    std::vector<std::vector<double>> states, controls;
    for (int l = 0; l < kLaneWidth; ++l) {
      states.push_back(state_of(*system, random_mimic_state(model, random)));
      controls.push_back(random_controls(system->nu(), random));
      for (int i = 0; i < system->nx(); ++i) x[i].set(l, states[l][i]);
      for (int i = 0; i < system->nu(); ++i) u[i].set(l, controls[l][i]);
    }
    system->differentiate(x.data(), u.data(), *lanes);
    const auto data = system->create_data(double{});
    for (int l = 0; l < kLaneWidth; ++l) {
      system->differentiate(states[l].data(), controls[l].data(), *data);
      const auto expect_same = [&](const AlignedVector<Lane>& a, const AlignedVector<double>& b) {
        ASSERT_EQ(a.size(), b.size());
        double scale = 1;
        for (double value : b) scale = std::max(scale, std::abs(value));
        for (std::size_t i = 0; i < b.size(); ++i)
          EXPECT_NEAR(a[i][l], b[i], 1e-11 * scale) << name << " lane " << l;
      };
      expect_same(lanes->f, data->f);
      expect_same(lanes->fx, data->fx);
      expect_same(lanes->fu, data->fu);
    }
  }
}

TEST(Mimic, StateHasIndependentJointsAndExpandsToAll) {
  RandomNumbers random(64);
  for (const auto& [name, model] : mimic_robots()) {
    const auto system = system_of(model);
    const int mimics = static_cast<int>(model.mimics.size());
    EXPECT_EQ(system->nq(), model.nq - mimics);
    EXPECT_EQ(system->nv(), model.nv - mimics);
    ASSERT_EQ(static_cast<int>(system->state_columns().size()), system->nx());
    const RobotState state = random_mimic_state(model, random);
    const std::vector<double> q =
        system->expand_configuration(system->reduce_configuration(state.q));
    const std::vector<double> v = system->expand_velocity(system->reduce_velocity(state.v));
    for (int i = 0; i < model.nq; ++i) EXPECT_NEAR(q[i], state.q[i], 1e-14) << name;
    for (int i = 0; i < model.nv; ++i) EXPECT_NEAR(v[i], state.v[i], 1e-14) << name;
    // Power is equal in both coordinates.
    const std::vector<double> reduced_v = system->reduce_velocity(state.v);
    const std::vector<double> force = system->reduce_force(state.tau);
    double power = 0, full_power = 0;
    for (int i = 0; i < system->nv(); ++i) power += force[i] * reduced_v[i];
    for (int i = 0; i < model.nv; ++i) full_power += state.tau[i] * state.v[i];
    EXPECT_NEAR(power, full_power, 1e-12 * (1 + std::abs(full_power)));

    const std::vector<double> x = state_of(*system, state);
    for (int i = 0; i < model.joint_count(); ++i) {
      const Joint& joint = model.joints[i];
      bool follows = false;
      for (const Mimic& mimic : model.mimics) follows |= mimic.joint == i;
      EXPECT_EQ(system->position_index(i).has_value(), !follows);
      EXPECT_EQ(system->velocity_index(i).has_value(), !follows);
      EXPECT_EQ(system->velocity_row(i).has_value(), !follows);
      if (follows) continue;
      EXPECT_EQ(x[*system->position_index(i)], state.q[joint.q]);
      EXPECT_EQ(x[*system->velocity_index(i)], state.v[joint.v]);
      if (joint.type == JointType::floating) continue;
      EXPECT_EQ(system->state_columns()[*system->position_index(i)].name, "q/" + joint.name);
      EXPECT_EQ(system->state_columns()[*system->velocity_index(i)].name, "v/" + joint.name);
    }
  }
}

TEST(Mimic, ControlsActOnIndependentJoints) {
  const RobotModel model = mimic_robots().front().model;
  const Actuation full = Actuation::full(model);
  EXPECT_EQ(full.nu, model.nv - 3);
  for (const Column& column : full.columns)
    for (const Mimic& mimic : model.mimics)
      EXPECT_NE(column.name, "u/" + model.joints[mimic.joint].name);
  try {
    Actuation::joints(model, {model.joints[0].name});
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "joint joint0 mimics joint joint3: controls act on independent joints");
  }
  // A manual control matrix that pushes a mimic joint acts on its leader: GᵀB.
  Actuation by_hand = Actuation::joints(model, {"joint3"});
  std::fill(by_hand.B.begin(), by_hand.B.end(), 0.0);
  by_hand.B[0] = 2;
  const MultibodySystem system(std::make_shared<RobotModel>(model), by_hand);
  ASSERT_EQ(system.actuated_rows(), std::vector<int>{*system.velocity_row(3)});
  EXPECT_EQ(system.actuation().B[*system.velocity_row(3)], 2 * -0.7);
}

TEST(Mimic, PassiveForcesOfAllJointsDissipateEnergy) {
  RandomNumbers random(65);
  for (const auto& [name, model] : mimic_robots()) {
    const auto system = system_of(model);
    const MultibodySystem plain(std::make_shared<RobotModel>(model), Actuation::full(model));
    const auto a = system->create_data(double{}), b = plain.create_data(double{});
    const RobotState state = random_mimic_state(model, random);
    const std::vector<double> x = state_of(*system, state), u(system->nu(), 0.0);
    system->evaluate(x.data(), u.data(), *a);
    plain.evaluate(x.data(), u.data(), *b);
    // Power of the acceleration difference, compared with the full robot's passive forces.
    const auto& robot = static_cast<MultibodySystem::Data<double>&>(*a).robot;
    const auto& free = static_cast<MultibodySystem::Data<double>&>(*b).robot;
    const Map<const VectorXd> with(robot.acceleration.data(), model.nv);
    const Map<const VectorXd> without(free.acceleration.data(), model.nv);
    const Map<const VectorXd> v(state.v.data(), model.nv);
    const double power = v.dot(full_mass_matrix(model, robot) * (with - without));
    const double expected = v.dot(passive_forces(model, state.v));
    EXPECT_LT(expected, 0);
    EXPECT_NEAR(power, expected, 1e-9 * (1 + std::abs(expected))) << name;
  }
}

constexpr const char* kGripper = R"(<robot name="gripper">
  <link name="palm"/>
  <joint name="left" type="prismatic"><parent link="palm"/><child link="l"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" effort="20" velocity="0.2"/></joint>
  <link name="l"><inertial><mass value="0.1"/>
    <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
  <joint name="right" type="prismatic"><parent link="palm"/><child link="r"/><axis xyz="0 1 0"/>
    <limit lower="-0.03" upper="0.01" effort="20" velocity="0.1"/>
    <mimic joint="left" multiplier="-1" offset="0.005"/></joint>
  <link name="r"><inertial><mass value="0.1"/>
    <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
</robot>)";

TEST(Mimic, UrdfGripperMovesAsOneHeavierJoint) {
  const UrdfResult result = parse_urdf(kGripper, "gripper", {.enforce_mimic = true});
  ASSERT_TRUE(result.model.has_value());
  const MultibodySystem system(std::make_shared<RobotModel>(*result.model),
                               Actuation::full(*result.model));
  ASSERT_EQ(system.nx(), 2);
  EXPECT_EQ(system.state_columns()[0].name, "q/left");
  EXPECT_EQ(system.state_columns()[1].name, "v/left");
  EXPECT_EQ(system.control_columns()[0].name, "u/left");
  const auto data = system.create_data(double{});
  const double x[] = {0.02, 0.05}, u[] = {3};
  system.evaluate(x, u, *data);
  EXPECT_NEAR(data->f[0], 3 / 0.2, 1e-12);
  // The right finger's range maps to [-0.005, 0.035], its speed to 0.1.
  const MultibodySystem::JointLimits limits = system.limits(0);
  EXPECT_DOUBLE_EQ(limits.lower, 0);
  EXPECT_DOUBLE_EQ(limits.upper, 0.035);
  EXPECT_DOUBLE_EQ(limits.max_velocity, 0.1);
}

TEST(Mimic, RobotWithoutMimicJointsAllocatesNoBuffers) {
  const RobotModel model = random_robot(66, {.joints = 5, .floating = true});
  const auto system = system_of(model);
  EXPECT_TRUE(system->mimic_map().identity());
  const MultibodySystem::Data<double> data(*system);
  EXPECT_TRUE(data.mimic.q.empty() && data.mimic.M.empty() && data.mimic.columns.empty());
  for (int i = 0; i < model.joint_count(); ++i) {
    EXPECT_EQ(system->position_index(i), model.joints[i].q);
    EXPECT_EQ(system->velocity_index(i), model.nq + model.joints[i].v);
  }
  EXPECT_EQ(system->actuation().B, Actuation::full(model).B);
}

TEST(Mimic, RejectsUnenforceableConstraints) {
  const RobotModel plain = random_robot(67, {.joints = 4, .floating = true});
  const auto attempt = [&](std::vector<Mimic> mimics) {
    RobotModel model = plain;
    model.mimics = std::move(mimics);
    MimicMap map(model);
  };
  EXPECT_NO_THROW(attempt({{1, 2, 1, 0}, {3, 2, 1, 0}}));
  EXPECT_THROW(attempt({{1, 2, 1, 0}, {2, 3, 1, 0}}), std::invalid_argument);  // a chain
  EXPECT_THROW(attempt({{1, 1, 1, 0}}), std::invalid_argument);
  EXPECT_THROW(attempt({{1, 2, 1, 0}, {1, 3, 1, 0}}), std::invalid_argument);
  EXPECT_THROW(attempt({{1, 0, 1, 0}}), std::invalid_argument);  // follows the floating base
  EXPECT_THROW(attempt({{0, 1, 1, 0}}), std::invalid_argument);
}

TEST(Mimic, ZeroMultiplierLocksTheJoint) {
  // q = 0·q_leader + offset: the robot of the URDF with that joint locked at the offset.
  const auto hinge = [](const std::string& name, const std::string& from, const std::string& to,
                        const std::string& more) {
    return "<joint name='" + name + "' type='continuous'><parent link='" + from +
           "'/><child link='" + to + "'/><origin xyz='0.1 0.2 0.5' rpy='0.3 0.5 0.1'/>" +
           "<axis xyz='0 1 0'/>" + more + "</joint><link name='" + to +
           "'><inertial><origin xyz='0.1 0 0.2'/><mass value='2'/><inertia ixx='0.1' ixy='0.01' "
           "ixz='0' iyy='0.12' iyz='0' izz='0.08'/></inertial></link>";
  };
  const std::string xml = "<robot name='r'><link name='base'/>" + hinge("a", "base", "la", "") +
                          hinge("b", "la", "lb", "<mimic joint='a' multiplier='0' offset='0.7'/>") +
                          hinge("c", "lb", "lc", "") + "</robot>";
  const auto mimicking = parse_urdf(xml, "r", {.enforce_mimic = true});
  const auto locked = parse_urdf(xml, "r", {.locked_joints = {{"b", 0.7}}});
  ASSERT_TRUE(mimicking.model && locked.model);
  const auto one = system_of(*mimicking.model), two = system_of(*locked.model);
  ASSERT_EQ(one->nx(), 4);
  const double x[] = {0.4, -1.1, 1.3, -0.6}, u[] = {2, -3};
  const auto a = one->create_data(double{}), b = two->create_data(double{});
  one->differentiate(x, u, *a);
  two->differentiate(x, u, *b);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(a->f[i], b->f[i], 1e-12 * (1 + std::abs(b->f[i])));
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(a->fx[i], b->fx[i], 1e-11 * (1 + std::abs(b->fx[i])));
}

TEST(DenseLdlt, MatchesEigen) {
  RandomNumbers random(68);
  for (const int n : {1, 2, 5, 13}) {
    MatrixXd R(n, n);
    VectorXd x(n);
    for (int i = 0; i < n * n; ++i) R.data()[i] = random.uniform(-1, 1);
    for (int i = 0; i < n; ++i) x[i] = random.uniform(-1, 1);
    const MatrixXd A = R * R.transpose() + 0.1 * MatrixXd::Identity(n, n);
    const VectorXd expected = A.llt().solve(x);
    MatrixXd factors = A;
    factors.triangularView<Eigen::StrictlyUpper>().setConstant(1e300);  // not read
    factorize_ldlt(n, factors.data());
    solve_ldlt(n, factors.data(), x.data());
    EXPECT_LT((x - expected).norm(), 1e-10 * (1 + expected.norm())) << n;
  }
}

}  // namespace
}  // namespace conddp
