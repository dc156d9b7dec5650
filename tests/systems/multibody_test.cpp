#include "systems/multibody/multibody.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "robot/frames.hpp"
#include "robot/model.hpp"
#include "support/random_robot.hpp"
#include "support/robots.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Base = UrdfOptions::Base;

/// Loads problems/robots/<name>.urdf.
RobotModel load(const std::string& name, const UrdfOptions& options) {
  const UrdfResult result =
      load_urdf(source_tree() / "problems/robots" / (name + ".urdf"), options);
  if (!result.model) throw std::runtime_error("cannot load " + name);
  return *result.model;
}

std::shared_ptr<const MultibodySystem> make_system(const RobotModel& model, Actuation actuation,
                                                   PassiveForces passive = {}) {
  return std::make_shared<MultibodySystem>(std::make_shared<RobotModel>(model),
                                           std::move(actuation), passive);
}

std::vector<double> joined(std::vector<double> q, const std::vector<double>& v) {
  q.insert(q.end(), v.begin(), v.end());
  return q;
}

MatrixXd full_mass_matrix(const RobotModel& model, const std::vector<double>& q) {
  RobotData<double> data(model);
  update_placements(model, q.data(), data);
  mass_matrix(model, data);
  return MatrixXd(Map<const MatrixXd>(data.M.data(), model.nv, model.nv))
      .selfadjointView<Eigen::Lower>();
}

/// Generalized forces minus bias that give a system's acceleration at (q, v, u), by inverse
/// dynamics: the sum of actuation and passive forces.
VectorXd applied_forces(const MultibodySystem& system, const RobotState& state,
                        const std::vector<double>& u) {
  const auto data = system.create_data(double{});
  system.evaluate(joined(state.q, state.v).data(), u.data(), *data);
  RobotData<double> robot(system.robot());
  inverse_dynamics(system.robot(), state.q.data(), state.v.data(), data->f.data(), robot);
  return Map<const VectorXd>(robot.tau.data(), system.nv());
}

double energy(const RobotModel& model, const std::vector<double>& x) {
  RobotData<double> data(model);
  update_placements(model, x.data(), data);
  update_velocities(model, x.data() + model.nq, data);
  update_composite_inertias(model, data);
  return kinetic_energy(model, data) + potential_energy(model, data);
}

/// One step of the classical Runge-Kutta rule on a flat state space.
std::vector<double> rk4_step(const System& system, const std::vector<double>& x,
                             const std::vector<double>& u, double dt) {
  const auto data = system.create_data(double{});
  const int nv = system.nv();
  const auto rate = [&](const VectorXd& at) {
    system.evaluate(at.data(), u.data(), *data);
    VectorXd f(2 * nv);
    f << at.tail(nv), Map<const VectorXd>(data->f.data(), nv);
    return f;
  };
  const VectorXd x0 = Map<const VectorXd>(x.data(), 2 * nv);
  const VectorXd k1 = rate(x0), k2 = rate(x0 + dt / 2 * k1), k3 = rate(x0 + dt / 2 * k2),
                 k4 = rate(x0 + dt * k3);
  const VectorXd next = x0 + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  return {next.begin(), next.end()};
}

RobotModel damped_robot(std::uint64_t seed, bool floating) {
  RobotModel model = random_robot(seed, {.joints = 5, .floating = floating, .wrenches = 0});
  for (Joint& joint : model.joints) {
    joint.damping = 0.2 + 0.1 * joint.v;
    joint.friction = 0.5 + 0.05 * joint.v;
  }
  return model;
}

TEST(Multibody, PassiveForcesMatchUrdfOnRequest) {
  RandomNumbers random(81);
  for (const bool floating : {false, true})
    for (const bool damping : {false, true})
      for (const bool friction : {false, true}) {
        const RobotModel model = damped_robot(82, floating);
        const auto system = make_system(model, Actuation::full(model), {damping, friction, 0.3});
        const RobotState state = random_state(model, random);
        VectorXd expected = VectorXd::Zero(model.nv);
        for (const Joint& joint : model.joints) {
          if (joint.type == JointType::floating) continue;
          const double v = state.v[joint.v];
          if (damping) expected[joint.v] -= joint.damping * v;
          if (friction) expected[joint.v] -= joint.friction * std::tanh(v / 0.3);
        }
        const std::vector<double> none(system->nu(), 0.0);
        const VectorXd force = applied_forces(*system, state, none);
        EXPECT_LT((force - expected).lpNorm<Eigen::Infinity>(), 1e-9);
        EXPECT_LE(force.dot(Map<const VectorXd>(state.v.data(), model.nv)), 1e-9);
      }
}

TEST(Multibody, PassiveForcesHaveNegativeSlopes) {
  RandomNumbers random(83);
  const RobotModel model = damped_robot(84, true);
  const auto plain = make_system(model, Actuation::full(model));
  const auto damped = make_system(model, Actuation::full(model), {true, true, 0.3});
  const RobotState state = random_state(model, random);
  const std::vector<double> x = joined(state.q, state.v), u(plain->nu(), 0.0);
  const auto a = plain->create_data(double{}), b = damped->create_data(double{});
  plain->differentiate(x.data(), u.data(), *a);
  damped->differentiate(x.data(), u.data(), *b);
  // M (∂a/∂v − ∂a/∂v without) is the slope of the passive forces: diagonal and negative.
  const int n = model.nv;
  const MatrixXd slope =
      full_mass_matrix(model, state.q) * (Map<const MatrixXd>(b->fx.data() + n * n, n, n) -
                                          Map<const MatrixXd>(a->fx.data() + n * n, n, n));
  MatrixXd expected = MatrixXd::Zero(n, n);
  for (const Joint& joint : model.joints) {
    if (joint.type == JointType::floating) continue;
    const double cosh = std::cosh(state.v[joint.v] / 0.3);
    expected(joint.v, joint.v) = -joint.damping - joint.friction / 0.3 / (cosh * cosh);
    EXPECT_LT(slope(joint.v, joint.v), 0);
  }
  EXPECT_LT((slope - expected).lpNorm<Eigen::Infinity>(), 1e-9);
}

TEST(Multibody, FrictionStaysFiniteAtAnySpeed) {
  RobotModel model = damped_robot(85, false);
  const auto system = make_system(model, Actuation::full(model), {false, true, 1e-6});
  const auto data = system->create_data(double{});
  std::vector<double> x(system->nx(), 0.0);
  for (int i = 0; i < system->nv(); ++i) x[system->nq() + i] = i % 2 ? 50 : -50;
  const std::vector<double> u(system->nu(), 0.0);
  system->differentiate(x.data(), u.data(), *data);
  for (double a : data->f) EXPECT_TRUE(std::isfinite(a));
  for (double a : data->fx) EXPECT_TRUE(std::isfinite(a));
}

TEST(Multibody, EnergyFallsOnlyWithDamping) {
  RandomNumbers random(86);
  const RobotModel model = damped_robot(87, false);
  const auto free = make_system(model, Actuation::full(model));
  const auto damped = make_system(model, Actuation::full(model), {true, true, 0.3});
  const std::vector<double> start =
      joined(random.numbers(model.nq, 1), random.numbers(model.nv, 0.5));
  const std::vector<double> u(free->nu(), 0.0);
  const double first = energy(model, start);
  std::vector<double> x = start, y = start;
  double last = first;
  for (int step = 0; step < 500; ++step) {
    x = rk4_step(*free, x, u, 1e-3);
    y = rk4_step(*damped, y, u, 1e-3);
    const double now = energy(model, y);
    EXPECT_LT(now, last) << "step " << step;
    last = now;
  }
  EXPECT_NEAR(energy(model, x), first, 1e-8 * (1 + std::abs(first)));
  EXPECT_LT(last, first - 1e-3);
}

TEST(Multibody, ThrustersPushWithForceTorqueAndReaction) {
  RandomNumbers random(88);
  const RobotModel model = random_robot(89, {.joints = 3, .floating = true, .wrenches = 0});
  std::vector<int> frames;
  for (int f = 0; f < static_cast<int>(model.frames.size()); ++f)
    if (model.frames[f].joint == 0) frames.push_back(f);
  ASSERT_GE(frames.size(), 2u);
  const double c = std::sqrt(0.5);
  const std::vector<Thruster> thrusters = {
      {.name = "one", .frame = frames[0], .direction = {0, 0, 1}, .torque_ratio = 0.1, .upper = 9},
      {.name = "two",
       .frame = frames[1],
       .direction = {c, 0, -c},
       .torque_ratio = -0.2,
       .lower = -3},
      {.name = "three", .frame = frames[1], .direction = {0, 1, 0}}};
  const auto system = make_system(model, Actuation::thrusters(model, thrusters, {"joint1"}));
  ASSERT_EQ(system->nu(), 4);
  EXPECT_EQ(system->control_columns()[1].name, "u/two");
  EXPECT_EQ(system->control_columns()[1].unit, "N");
  EXPECT_EQ(system->control_columns()[3].name, "u/joint1");
  EXPECT_EQ(system->control_lower()[0], 0);
  EXPECT_EQ(system->control_upper()[0], 9);
  EXPECT_EQ(system->control_lower()[1], -3);
  EXPECT_EQ(system->control_upper()[1], kUnlimited);

  const RobotState state = random_state(model, random);
  const std::vector<double> u = {4, 2, -1.5, 0.7};
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  for (int t = 0; t < 3; ++t) {
    const SE3<double>& m = model.frames[thrusters[t].frame].placement;
    Eigen::Matrix3d R;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) R(i, j) = m.R(i, j);
    const Eigen::Vector3d d(thrusters[t].direction.x, thrusters[t].direction.y,
                            thrusters[t].direction.z);
    const Eigen::Vector3d push = u[t] * (R * d), arm(m.p.x, m.p.y, m.p.z);
    force += push;
    torque += arm.cross(push) + thrusters[t].torque_ratio * push;
  }
  VectorXd expected = VectorXd::Zero(model.nv);
  expected << force, torque, 0, u[3], 0;
  EXPECT_LT((applied_forces(*system, state, u) - expected).norm(), 1e-9);
}

TEST(Multibody, ThrustersNeedAFrameOfAFloatingBase) {
  const RobotModel floating = random_robot(90, {.joints = 2, .floating = true});
  const RobotModel bolted = random_robot(91, {.joints = 2});
  const int on_joint = *floating.find_frame("joint1"), on_world = *floating.find_frame("world");
  for (const auto& [model, frame] :
       {std::pair{&floating, on_joint}, {&floating, on_world}, {&bolted, 2}})
    EXPECT_THROW(Actuation::thrusters(*model, {{.name = "t", .frame = frame}}, {}),
                 std::invalid_argument);
}

TEST(Multibody, ActuatesListedJointsInListOrder) {
  RandomNumbers random(92);
  RobotModel model = random_robot(93, {.joints = 5, .floating = true, .wrenches = 0});
  model.joints[*model.find_joint("joint3")].max_effort = 7;
  const auto system = make_system(model, Actuation::joints(model, {"joint3", "joint1"}));
  ASSERT_EQ(system->nu(), 2);
  EXPECT_EQ(system->control_columns()[0].name, "u/joint3");
  EXPECT_EQ(system->control_columns()[1].name, "u/joint1");
  EXPECT_EQ(system->control_lower(), (std::vector<double>{-7, -kUnlimited}));
  EXPECT_EQ(system->control_upper(), (std::vector<double>{7, kUnlimited}));
  const int one = model.joints[*model.find_joint("joint1")].v;
  const int three = model.joints[*model.find_joint("joint3")].v;
  EXPECT_EQ(system->actuated_rows(), (std::vector<int>{one, three}));
  VectorXd expected = VectorXd::Zero(model.nv);
  expected[three] = 2;
  expected[one] = -3;
  const VectorXd force = applied_forces(*system, random_state(model, random), {2, -3});
  EXPECT_LT((force - expected).norm(), 1e-9);

  EXPECT_THROW(Actuation::joints(model, {"joint9"}), std::invalid_argument);
  EXPECT_THROW(Actuation::joints(model, {"base"}), std::invalid_argument);
  EXPECT_EQ(Actuation::full(model).nu, 5);
}

TEST(Multibody, TreesOfOneModelMoveIndependently) {
  RandomNumbers random(94);
  const std::vector<RobotModel> trees = {random_robot(95, {.joints = 3, .floating = true}),
                                         random_robot(96, {.joints = 4}),
                                         random_robot(97, {.joints = 0, .floating = true})};
  const RobotModel all = combine(trees);
  const auto system = make_system(all, Actuation::full(all));
  const auto data = system->create_data(double{});
  std::vector<double> q, v, u;
  std::vector<RobotState> states;
  std::vector<std::vector<double>> controls;
  for (const RobotModel& tree : trees) {
    states.push_back(random_state(tree, random));
    controls.push_back(random.numbers(Actuation::full(tree).nu, 10));
    q = joined(q, states.back().q);
    v = joined(v, states.back().v);
    u = joined(u, controls.back());
  }
  system->differentiate(joined(q, v).data(), u.data(), *data);
  const MatrixXd M = full_mass_matrix(all, q);
  const int n = all.nv;
  const Map<const MatrixXd> fx(data->fx.data(), n, 2 * n);
  int at = 0;
  for (std::size_t t = 0; t < trees.size(); ++t) {
    const auto own = make_system(trees[t], Actuation::full(trees[t]));
    const auto own_data = own->create_data(double{});
    own->differentiate(joined(states[t].q, states[t].v).data(), controls[t].data(), *own_data);
    const int m = own->nv();
    for (int i = 0; i < m; ++i)
      EXPECT_NEAR(data->f[at + i], own_data->f[i], 1e-10 * (1 + std::abs(own_data->f[i])));
    MatrixXd outside = M.middleRows(at, m);
    EXPECT_LT((outside.middleCols(at, m) - full_mass_matrix(trees[t], states[t].q)).norm(), 1e-11);
    outside.middleCols(at, m).setZero();
    EXPECT_EQ(outside.norm(), 0);
    MatrixXd foreign = fx.middleRows(at, m);
    const Map<const MatrixXd> own_fx(own_data->fx.data(), m, 2 * m);
    EXPECT_LT((foreign.middleCols(at, m) - own_fx.leftCols(m)).norm(), 1e-9 * own_fx.norm());
    EXPECT_LT((foreign.middleCols(n + at, m) - own_fx.rightCols(m)).norm(), 1e-9 * own_fx.norm());
    foreign.middleCols(at, m).setZero();
    foreign.middleCols(n + at, m).setZero();
    EXPECT_EQ(foreign.norm(), 0);
    at += m;
  }
}

TEST(Multibody, LockedJointIsLimitOfAnImmovableJoint) {
  const double angle = 0.6;
  const RobotModel locked = load("arm7", {.locked_joints = {{"joint_3", angle}}});
  const RobotModel heavy = load("arm7", {.rotor_inertia = {{"joint_3", 1e10}}});
  ASSERT_EQ(locked.nv, heavy.nv - 1);
  RandomNumbers random(98);
  const int held = heavy.joints[*heavy.find_joint("joint_3")].v;
  RobotState state = random_state(heavy, random);
  state.q[held] = angle;
  state.v[held] = 0;
  std::vector<double> u = random.numbers(heavy.nv, 20);
  const auto a = make_system(heavy, Actuation::full(heavy));
  const auto data = a->create_data(double{});
  a->evaluate(joined(state.q, state.v).data(), u.data(), *data);
  EXPECT_LT(std::abs(data->f[held]), 1e-7);

  for (std::vector<double>* numbers : {&state.q, &state.v, &u})
    numbers->erase(numbers->begin() + held);
  const auto b = make_system(locked, Actuation::full(locked));
  const auto expected = b->create_data(double{});
  b->evaluate(joined(state.q, state.v).data(), u.data(), *expected);
  for (int i = 0; i < locked.nv; ++i)
    EXPECT_NEAR(data->f[i < held ? i : i + 1], expected->f[i],
                1e-6 * (1 + std::abs(expected->f[i])));
}

TEST(Multibody, PayloadAddsItsInertiaAndWeight) {
  const RobotModel bare = load("arm7", {});
  const std::string link = bare.frames.back().kind == FrameKind::link
                               ? bare.frames.back().name
                               : bare.frames[bare.frames.size() - 2].name;
  const double mass = 1.3;
  const Vector3<double> com{0.02, -0.03, 0.08};
  const RobotModel loaded = load("arm7", {.payloads = {{.link = link, .mass = mass, .com = com}}});
  RandomNumbers random(99);
  const RobotState state = random_state(bare, random);
  // Jacobian of the payload's center, from a frame placed there.
  RobotModel marked = bare;
  Frame frame = bare.frames[*bare.find_frame(link)];
  frame.placement = frame.placement * SE3<double>{Matrix3<double>::identity(), com};
  marked.frames.push_back(frame);
  RobotData<double> data(marked);
  update_placements(marked, state.q.data(), data);
  const int index = static_cast<int>(marked.frames.size()) - 1;
  const std::vector<int> columns = support(marked, frame.joint);
  MatrixXd part(3, columns.size()), J = MatrixXd::Zero(3, bare.nv);
  frame_position_jacobian(marked, data, index, part.data());
  for (std::size_t c = 0; c < columns.size(); ++c) J.col(columns[c]) = part.col(c);
  const MatrixXd added = full_mass_matrix(loaded, state.q) - full_mass_matrix(bare, state.q);
  EXPECT_LT((added - mass * J.transpose() * J).norm(), 1e-11);

  RobotData<double> a(bare), b(loaded);
  const std::vector<double> zero(bare.nv, 0.0);
  inverse_dynamics(bare, state.q.data(), zero.data(), zero.data(), a);
  inverse_dynamics(loaded, state.q.data(), zero.data(), zero.data(), b);
  const VectorXd weight = mass * 9.81 * J.row(2).transpose();
  for (int i = 0; i < bare.nv; ++i) EXPECT_NEAR(b.tau[i] - a.tau[i], weight[i], 1e-11);
}

TEST(Multibody, ColumnsAreNamedAfterJointsWithUnits) {
  const RobotModel model =
      combine({load("quadrotor", {.base = Base::floating}), load("cartpole", {})});
  const auto system = make_system(model, Actuation::joints(model, {"slider", "hinge"}));
  const std::vector<std::pair<const char*, const char*>> expected = {
      {"base/x", "m"},      {"base/y", "m"},      {"base/z", "m"},      {"base/qx", "1"},
      {"base/qy", "1"},     {"base/qz", "1"},     {"base/qw", "1"},     {"q/slider", "m"},
      {"q/hinge", "rad"},   {"base/vx", "m/s"},   {"base/vy", "m/s"},   {"base/vz", "m/s"},
      {"base/wx", "rad/s"}, {"base/wy", "rad/s"}, {"base/wz", "rad/s"}, {"v/slider", "m/s"},
      {"v/hinge", "rad/s"}};
  ASSERT_EQ(system->state_columns().size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(system->state_columns()[i].name, expected[i].first);
    EXPECT_EQ(system->state_columns()[i].unit, expected[i].second);
  }
  EXPECT_EQ(system->control_columns()[0].unit, "N");
  EXPECT_EQ(system->control_columns()[1].unit, "Nm");
  EXPECT_EQ(system->control_upper()[0], 10);
  EXPECT_EQ(system->manifold().curved().size(), 1u);
  EXPECT_EQ(system->nx(), 17);
  EXPECT_EQ(system->ndx(), 16);
}

}  // namespace
}  // namespace conddp
