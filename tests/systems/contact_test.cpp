// Equations of contacts and impulses, checked by code that shares only the kinematics and dynamics
// of free robots; derivatives, compared with dual numbers.
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "robot/frames.hpp"
#include "support/contact_case.hpp"
#include "support/source_tree.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Data = MultibodySystem::Data<double>;
using D = Dual<double>;

Actuation actuation_of(const RobotModel& model) { return Actuation::full(model); }

std::shared_ptr<const MultibodySystem> held(const ContactCase& c) {
  return std::make_shared<MultibodySystem>(c.robot, actuation_of(*c.robot), PassiveForces{},
                                           c.contacts);
}
std::shared_ptr<const MultibodySystem> hit(const ContactCase& c, double restitution) {
  return std::make_shared<MultibodySystem>(c.robot, c.contacts, restitution);
}

/// A random state of the system (independent joints).
std::vector<double> random_system_state(const MultibodySystem& system, RandomNumbers& random) {
  const RobotState s = random_state(system.robot(), random);
  std::vector<double> x = system.reduce_configuration(s.q);
  const std::vector<double> v = system.reduce_velocity(s.v);
  x.insert(x.end(), v.begin(), v.end());
  return x;
}

std::vector<double> random_control(const MultibodySystem& system, RandomNumbers& random) {
  std::vector<double> u(system.nu());
  for (double& a : u) a = random.uniform(-10, 10);
  return u;
}

/// Constrained rows of a contact's point velocity or frame twist, from the frame's rotation and
/// world vectors.
VectorXd rows_of(const Contact& c, const Matrix3<double>& R, const Vector3<double>& linear,
                 const Vector3<double>& angular) {
  const auto put = [](const Vector3<double>& a) { return Eigen::Vector3d(a.x, a.y, a.z); };
  const Vector3<double> normal = c.axes == FrameAxes::local ? R * c.normal : c.normal;
  const Vector3<double> tangent = c.axes == FrameAxes::local ? R * c.tangent : c.tangent;
  VectorXd rows(c.rows());
  switch (c.kind) {
    case ContactKind::normal:
      rows << dot(normal, linear);
      break;
    case ContactKind::planar:
      rows << dot(normal, linear), dot(tangent, linear);
      break;
    case ContactKind::point:
      rows << put(transpose_times(R, linear));
      break;
    case ContactKind::surface:
      rows << put(transpose_times(R, linear)), put(transpose_times(R, angular));
      break;
  }
  return rows;
}

/// Acceleration constraint of a contact: for a point, the acceleration of its position with
/// stabilizing terms; for a surface, the rate of the local twist. Uses dual numbers along the
/// motion.
VectorXd acceleration_rows(const RobotModel& model, const Contact& c, const std::vector<double>& q,
                           const std::vector<double>& v, const std::vector<double>& a) {
  StateManifold manifold;
  for (const Joint& joint : model.joints)
    manifold.append(
        joint.type == JointType::floating ? StateManifold::Part::se3 : StateManifold::Part::flat,
        1);
  std::vector<D> qd(q.begin(), q.end()), step(model.nv), vd(model.nv);
  for (int i = 0; i < model.nv; ++i) {
    step[i] = D(0.0, v[i]);
    vd[i] = D(v[i], a[i]);
  }
  // Exact to first order in time, as dual numbers require.
  for (const Joint& joint : model.joints) {
    if (joint.type != JointType::floating) {
      qd[joint.q] = D(q[joint.q], v[joint.v]);
      continue;
    }
    const D* p = &qd[joint.q];
    const Pose<D> pose{{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}};
    const D* s = &step[joint.v];
    const Pose<D> moved = integrate_se3(pose, Motion<D>{{s[0], s[1], s[2]}, {s[3], s[4], s[5]}});
    qd[joint.q] = moved.p.x, qd[joint.q + 1] = moved.p.y, qd[joint.q + 2] = moved.p.z;
    qd[joint.q + 3] = moved.q.x, qd[joint.q + 4] = moved.q.y;
    qd[joint.q + 5] = moved.q.z, qd[joint.q + 6] = moved.q.w;
  }
  RobotData<D> data(model);
  update_placements(model, qd.data(), data);
  update_velocities(model, vd.data(), data);
  const RelativeFrame<D> frame(model, data, c);
  const SE3<D>& m = frame.placement;
  Matrix3<double> R;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R(i, j) = m.R(i, j).v;
  const auto value = [](const Vector3<D>& p) { return Vector3<double>{p.x.v, p.y.v, p.z.v}; };
  const auto rate = [](const Vector3<D>& p) { return Vector3<double>{p.x.d, p.y.d, p.z.d}; };
  if (c.kind == ContactKind::surface) {
    const Motion<D> twist = frame.twist();
    const Motion<double> error =
        difference_se3(Pose<double>{c.reference.p, quaternion(c.reference.R)},
                       Pose<double>{value(m.p), quaternion(R)});
    VectorXd rows(6);
    for (int i = 0; i < 6; ++i) rows[i] = twist[i].d + c.kd * twist[i].v + c.kp * error[i];
    return rows;
  }
  const Vector3<double> sum =
      rate(frame.v.linear) + c.kd * value(frame.v.linear) + c.kp * (value(m.p) - c.reference.p);
  return rows_of(c, R, sum, Vector3<double>::zero());
}

/// Generalized force of a force and torque in the world at a frame's origin.
VectorXd generalised_force(const RobotModel& model, RobotData<double>& data, int frame,
                           const Force<double>& f) {
  VectorXd tau = VectorXd::Zero(model.nv);
  if (model.frames[frame].joint < 0) return tau;
  const std::vector<int> columns = support(model, model.frames[frame].joint);
  MatrixXd J(6, columns.size());
  frame_jacobian(model, data, frame, FrameAxes::world_aligned, J.data());
  Eigen::Matrix<double, 6, 1> wrench;
  for (int i = 0; i < 6; ++i) wrench[i] = f[i];
  const VectorXd product = J.transpose() * wrench;
  for (std::size_t i = 0; i < columns.size(); ++i) tau[columns[i]] = product[i];
  return tau;
}

/// That of a contact's force and of the reaction on its base.
VectorXd generalised_force(const RobotModel& model, RobotData<double>& data, const Contact& c,
                           const Force<double>& f) {
  const VectorXd on_frame = generalised_force(model, data, c.frame, f);
  if (!c.base) return on_frame;
  const Vector3<double> lever =
      frame_placement(model, data, c.frame).p - frame_placement(model, data, *c.base).p;
  return on_frame -
         generalised_force(model, data, *c.base, {f.linear, f.angular + cross(lever, f.linear)});
}

/// ε λ of a contact.
VectorXd give(const MultibodySystem& system, const Data& data, int contact) {
  const ContactSet& set = system.contacts();
  return set.compliance() * Map<const VectorXd>(&data.contacts.force[set.offset(contact)],
                                                set.contacts()[contact].rows());
}

class ContactEquations : public testing::TestWithParam<ContactCase> {};
class ContactDerivatives : public testing::TestWithParam<ContactCase> {};

TEST_P(ContactEquations, ForcesHoldTheContacts) {
  const ContactCase& c = GetParam();
  const auto system = held(c);
  const RobotModel& model = *c.robot;
  RandomNumbers random(5);
  const auto data = system->create_data(double{});
  for (int trial = 0; trial < 3; ++trial) {
    const std::vector<double> x = random_system_state(*system, random);
    const std::vector<double> u = random_control(*system, random);
    system->evaluate(x.data(), u.data(), *data);
    const auto& d = static_cast<const Data&>(*data);
    const std::vector<double> q =
        system->expand_configuration({x.begin(), x.begin() + system->nq()});
    const std::vector<double> v = system->expand_velocity({x.begin() + system->nq(), x.end()});
    const std::vector<double> a = system->expand_velocity({d.f.begin(), d.f.end()});
    // Newton's law, by inverse dynamics.
    RobotData<double> robot(model);
    inverse_dynamics(model, q.data(), v.data(), a.data(), robot);
    VectorXd tau = Map<const VectorXd>(robot.tau.data(), model.nv);
    double scale = 1 + tau.lpNorm<Eigen::Infinity>();
    for (int i = 0; i < system->contacts().count(); ++i) {
      const VectorXd held_by = generalised_force(model, robot, c.contacts[i],
                                                 contact_force_in_world(d.contacts.contacts[i]));
      scale += held_by.lpNorm<Eigen::Infinity>();
      tau -= held_by;
    }
    const std::vector<double> reduced = system->reduce_force({tau.begin(), tau.end()});
    const MatrixXd B =
        Map<const MatrixXd>(system->actuation().B.data(), system->nv(), system->nu());
    const VectorXd applied = B * Map<const VectorXd>(u.data(), system->nu());
    EXPECT_LT(
        (Map<const VectorXd>(reduced.data(), system->nv()) - applied).lpNorm<Eigen::Infinity>(),
        (d.contacts.compliant ? 1e-7 : 1e-9) * scale);
    // Accelerations of the contacts.
    for (int i = 0; i < system->contacts().count(); ++i) {
      VectorXd rows = acceleration_rows(model, c.contacts[i], q, v, a);
      if (d.contacts.compliant) rows += give(*system, d, i);
      double size = 1;
      for (const double entry : a) size = std::max(size, std::abs(entry));
      EXPECT_LT(rows.lpNorm<Eigen::Infinity>(), (d.contacts.compliant ? 1e-7 : 1e-8) * size);
    }
  }
}

TEST_P(ContactEquations, ImpulseStopsContactsAndChangesMomentum) {
  const ContactCase& c = GetParam();
  const RobotModel& model = *c.robot;
  RandomNumbers random(6);
  for (const double restitution : {0.0, 0.4}) {
    const auto system = hit(c, restitution);
    const auto data = system->create_data(double{});
    const std::vector<double> x = random_system_state(*system, random);
    system->evaluate(x.data(), nullptr, *data);
    const auto& d = static_cast<const Data&>(*data);
    const std::vector<double> q =
        system->expand_configuration({x.begin(), x.begin() + system->nq()});
    const std::vector<double> before = system->expand_velocity({x.begin() + system->nq(), x.end()});
    const std::vector<double> after = system->expand_velocity({d.f.begin(), d.f.end()});
    RobotData<double> robot(model);
    update_placements(model, q.data(), robot);
    mass_matrix(model, robot);
    const MatrixXd M = MatrixXd(Map<const MatrixXd>(robot.M.data(), model.nv, model.nv))
                           .selfadjointView<Eigen::Lower>();
    VectorXd change = M * (Map<const VectorXd>(after.data(), model.nv) -
                           Map<const VectorXd>(before.data(), model.nv));
    for (int i = 0; i < system->contacts().count(); ++i)
      change -= generalised_force(model, robot, c.contacts[i],
                                  contact_force_in_world(d.contacts.contacts[i]));
    const std::vector<double> reduced = system->reduce_force({change.begin(), change.end()});
    const double scale = 1 + change.lpNorm<Eigen::Infinity>();
    EXPECT_LT(Map<const VectorXd>(reduced.data(), system->nv()).lpNorm<Eigen::Infinity>(),
              1e-9 * scale);
    for (int i = 0; i < system->contacts().count(); ++i) {
      const Contact& contact = c.contacts[i];
      const auto velocity = [&](const std::vector<double>& v) {
        update_velocities(model, v.data(), robot);
        const RelativeFrame<double> frame(model, robot, contact);
        return rows_of(contact, frame.placement.R, frame.v.linear, frame.v.angular);
      };
      VectorXd rows = velocity(after) + restitution * velocity(before);
      if (d.contacts.compliant) rows += give(*system, d, i);
      EXPECT_LT(rows.lpNorm<Eigen::Infinity>(), 1e-9);
    }
    const auto energy = [&](const std::vector<double>& v) {
      const Map<const VectorXd> velocity(v.data(), model.nv);
      return 0.5 * velocity.dot(M * velocity);
    };
    EXPECT_LE(energy(after), energy(before) * (1 + 1e-12));
  }
}

/// Derivatives of a system's outputs (f, then the contact forces), by dual numbers.
MatrixXd dual_derivatives(const MultibodySystem& system, const std::vector<double>& x,
                          const std::vector<double>& u) {
  using DL = Dual<Lane>;
  const auto data = system.create_data(DL{});
  const int n = system.ndx(), m = system.contacts().rows();
  MatrixXd result(system.nv() + m, n + system.nu());
  for (int direction = 0; direction < result.cols(); ++direction) {
    AlignedVector<DL> xd(x.begin(), x.end()), ud(u.begin(), u.end()), step(n, DL(0.0));
    if (direction < n) {
      step[direction].d = Lane(1.0);
      system.manifold().integrate(xd.data(), step.data(), xd.data());
    } else {
      ud[direction - n].d = Lane(1.0);
    }
    system.evaluate(xd.data(), ud.data(), *data);
    const auto& d = static_cast<const MultibodySystem::Data<DL>&>(*data);
    for (int i = 0; i < system.nv(); ++i) result(i, direction) = d.f[i].d[0];
    for (int i = 0; i < m; ++i) result(system.nv() + i, direction) = d.contacts.force[i].d[0];
  }
  return result;
}

/// The same, analytically.
MatrixXd analytic_derivatives(const MultibodySystem& system, const std::vector<double>& x,
                              const std::vector<double>& u) {
  const auto data = system.create_data(double{});
  system.differentiate(x.data(), u.data(), *data);
  const auto& d = static_cast<const Data&>(*data);
  const int nv = system.nv(), n = system.ndx(), m = system.contacts().rows();
  MatrixXd result(nv + m, n + system.nu());
  result.topLeftCorner(nv, n) = Map<const MatrixXd>(d.fx.data(), nv, n);
  result.topRightCorner(nv, system.nu()) = Map<const MatrixXd>(d.fu.data(), nv, system.nu());
  result.bottomRows(m) = Map<const MatrixXd>(d.contacts.force_z.data(), m, result.cols());
  return result;
}

void expect_equal_derivatives(const MultibodySystem& system, const std::vector<double>& x,
                              const std::vector<double>& u) {
  const auto data = system.create_data(double{});
  system.evaluate(x.data(), u.data(), *data);
  // For dependent rows, 1/ε amplifies rounding.
  const double tolerance = static_cast<const Data&>(*data).contacts.compliant ? 1e-6 : 1e-9;
  const MatrixXd expected = dual_derivatives(system, x, u);
  const MatrixXd found = analytic_derivatives(system, x, u);
  const int m = system.contacts().rows();
  const auto compare = [&](const MatrixXd& a, const MatrixXd& b, const char* what) {
    const double scale = 1 + b.lpNorm<Eigen::Infinity>();
    EXPECT_LT((a - b).lpNorm<Eigen::Infinity>(), tolerance * scale) << what;
  };
  compare(found.topRows(system.nv()), expected.topRows(system.nv()), "accelerations");
  compare(found.bottomRows(m), expected.bottomRows(m), "forces");
}

TEST_P(ContactDerivatives, AccelerationsAndForcesMatchDualNumbers) {
  RandomNumbers random(7);
  const auto system = held(GetParam());
  for (int trial = 0; trial < 2; ++trial)
    expect_equal_derivatives(*system, random_system_state(*system, random),
                             random_control(*system, random));
}

TEST_P(ContactDerivatives, VelocitiesAndImpulsesMatchDualNumbers) {
  RandomNumbers random(8);
  for (const double restitution : {0.0, 0.6}) {
    const auto system = hit(GetParam(), restitution);
    expect_equal_derivatives(*system, random_system_state(*system, random), {});
  }
}

/// Four points at the corners of each front foot of a quadruped: twelve rows, six of them
/// independent.
ContactCase corners_of_one_body() {
  RobotModel model = random_robot(9, {.joints = 9, .floating = true, .branching = 0.2});
  const int joint = model.joint_count() - 1;
  std::vector<Contact> contacts;
  for (int i = 0; i < 4; ++i) {
    Frame corner{.name = "corner_" + std::to_string(i), .joint = joint};
    corner.placement.p = {i % 2 ? 0.1 : -0.1, i / 2 ? 0.05 : -0.05, -0.02};
    model.frames.push_back(corner);
    contacts.push_back(
        {.name = corner.name, .frame = static_cast<int>(model.frames.size()) - 1, .kd = 5});
  }
  return {"corners", std::make_shared<RobotModel>(std::move(model)), std::move(contacts)};
}

TEST(RedundantContacts, HoldLikeASoleWithSmallestForces) {
  const ContactCase c = corners_of_one_body();
  const auto corners = held(c);
  Contact sole = c.contacts[0];
  sole.kind = ContactKind::surface;
  const auto surface = held({"sole", c.robot, {sole}});
  RandomNumbers random(41);
  std::vector<double> x = random_system_state(*corners, random);
  std::fill(x.begin() + corners->nq(), x.end(), 0.0);  // at rest both require the same
  const std::vector<double> u = random_control(*corners, random);
  const auto a = corners->create_data(double{}), b = surface->create_data(double{});
  corners->evaluate(x.data(), u.data(), *a);
  surface->evaluate(x.data(), u.data(), *b);
  EXPECT_TRUE(static_cast<const Data&>(*a).contacts.compliant);
  EXPECT_FALSE(static_cast<const Data&>(*b).contacts.compliant);
  double largest = 0;
  for (const double acceleration : b->f) largest = std::max(largest, std::abs(acceleration));
  for (int i = 0; i < corners->nv(); ++i) EXPECT_NEAR(a->f[i], b->f[i], 1e-3 * largest);
  // The smallest forces with a given sum and moment do not pull the corners apart.
  const auto& corner = static_cast<const Data&>(*a).contacts.contacts;
  for (const auto& [first, second] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 3)}) {
    const Vector3<double> f = contact_force_in_world(corner[first]).linear,
                          g = contact_force_in_world(corner[second]).linear;
    const Vector3<double> d = corner[second].world.p - corner[first].world.p;
    const double size = std::sqrt(squared_norm(f) + squared_norm(g));
    EXPECT_LT(std::abs(dot(g - f, d)), 1e-3 * (1 + size) * std::sqrt(squared_norm(d)));
  }
}

TEST(RedundantContacts, DoNotAffectOtherLanes) {
  // A stretched arm of two joints cannot move its tip along itself. The rows are dependent in that
  // lane, which must not affect the arms in the other lanes.
  const UrdfResult loaded = load_urdf(source_tree() / "problems/robots/double_pendulum.urdf", {});
  ASSERT_TRUE(loaded.model);
  const auto model = std::make_shared<RobotModel>(*loaded.model);
  const std::vector<Contact> contacts{
      {.name = "tip", .frame = moving_frames(*model).front(), .kind = ContactKind::planar}};
  const MultibodySystem system(model, Actuation::full(*model), {}, contacts);
  const auto lanes = system.create_data(Lane{});
  const auto one = system.create_data(double{});
  RandomNumbers random(43);
  AlignedVector<Lane> x(system.nx()), u(system.nu());
  std::vector<std::vector<double>> states, controls;
  for (int l = 0; l < kLaneWidth; ++l) {
    states.push_back(random_system_state(system, random));
    controls.push_back(random_control(system, random));
    if (l == 0) states[l][1] = 0;
    for (int i = 0; i < system.nx(); ++i) x[i].set(l, states[l][i]);
    for (int i = 0; i < system.nu(); ++i) u[i].set(l, controls[l][i]);
  }
  system.evaluate(x.data(), u.data(), *lanes);
  for (int l = 0; l < kLaneWidth; ++l) {
    system.evaluate(states[l].data(), controls[l].data(), *one);
    EXPECT_EQ(static_cast<const Data&>(*one).contacts.compliant, l == 0);
    for (int i = 0; i < system.nv(); ++i) {
      ASSERT_TRUE(std::isfinite(lanes->f[i][l]));
      EXPECT_NEAR(lanes->f[i][l], one->f[i], 1e-6 * (1 + std::abs(one->f[i]))) << "lane " << l;
    }
  }
}

std::string case_name(const testing::TestParamInfo<ContactCase>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(All, ContactEquations, testing::ValuesIn(contact_cases()), case_name);
INSTANTIATE_TEST_SUITE_P(All, ContactDerivatives, testing::ValuesIn(contact_cases()), case_name);

}  // namespace
}  // namespace conddp
