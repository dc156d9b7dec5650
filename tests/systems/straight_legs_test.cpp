// For straight legs, contacts may be dependent; their forces then use the compliance ε = 1e-6/mass.
// Derivatives are compared with dual numbers through it, in lanes with straight legs first and
// increasingly bent ones after.
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "robot/frames.hpp"
#include "support/contact_case.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

using Eigen::Map;
using Eigen::MatrixXd;
using DL = Dual<Lane>;

/// Frames at the ends of a robot's limbs.
std::vector<std::string> feet_of(const std::string& robot) {
  if (robot == "quadruped") return {"lf_foot", "rf_foot", "lh_foot", "rh_foot"};
  if (robot == "biped") return {"l_sole", "r_sole"};
  if (robot == "hopper") return {"foot"};
  if (robot == "double_pendulum") return {"tip"};
  return {"tool"};
}

struct StraightCase {
  std::string name;
  std::shared_ptr<const RobotModel> robot;
  std::vector<Contact> contacts;
};

/// Number of joints between a frame and the base; soles need six, or they are never dependent.
int limb_joints(const RobotModel& robot, int frame) {
  const int all = support_size(robot, robot.frames[frame].joint);
  return all - (robot.joints[0].type == JointType::floating ? 6 : 0);
}

std::vector<StraightCase> straight_cases() {
  RandomNumbers random(51);
  std::vector<StraightCase> cases;
  for (const TestRobot& r : five_robots()) {
    const auto robot = load(r);
    std::vector<int> frames;
    for (const std::string& foot : feet_of(r.name)) frames.push_back(*robot->find_frame(foot));
    const std::pair<const char*, ContactKind> kinds[] = {{"normal", ContactKind::normal},
                                                         {"planar", ContactKind::planar},
                                                         {"point", ContactKind::point},
                                                         {"surface", ContactKind::surface}};
    for (const auto& [word, kind] : kinds)
      for (const FrameAxes axes : {FrameAxes::world_aligned, FrameAxes::local}) {
        if (kind == ContactKind::surface && limb_joints(*robot, frames[0]) < 6) continue;
        std::vector<Contact> contacts;
        for (const int frame : frames)
          contacts.push_back(random_contact(frame, kind, axes, random));
        const char* where = axes == FrameAxes::local ? "_local_" : "_";
        cases.push_back({r.name + where + word, robot, std::move(contacts)});
      }
  }
  return cases;
}

/// States; the first has all joints at 0.
std::vector<std::vector<double>> bending_states(const MultibodySystem& system,
                                                RandomNumbers& random) {
  std::vector<std::vector<double>> states;
  for (int l = 0; l < kLaneWidth; ++l) {
    std::vector<double> x = system.manifold().neutral();
    for (int j = 0; j < system.robot().joint_count(); ++j)
      if (system.robot().joints[j].type != JointType::floating)
        x[*system.position_index(j)] = 0.3 * l * random.uniform(0.5, 1);
    for (int i = system.nq(); i < system.nx(); ++i) x[i] = random.uniform(-2, 2);
    states.push_back(std::move(x));
  }
  return states;
}

/// Derivatives of f and of the contact forces in every lane, by dual numbers.
std::vector<MatrixXd> dual_derivatives(const MultibodySystem& system,
                                       const std::vector<std::vector<double>>& states,
                                       const std::vector<double>& u) {
  const auto data = system.create_data(DL{});
  const int n = system.ndx(), m = system.contacts().rows(), columns = n + system.nu();
  std::vector<MatrixXd> result(kLaneWidth, MatrixXd(system.nv() + m, columns));
  for (int direction = 0; direction < columns; ++direction) {
    AlignedVector<DL> x(system.nx(), DL(0.0)), control(u.begin(), u.end()), step(n, DL(0.0));
    for (int l = 0; l < kLaneWidth; ++l)
      for (int i = 0; i < system.nx(); ++i) x[i].v.set(l, states[l][i]);
    if (direction < n) {
      step[direction].d = Lane(1.0);
      system.manifold().integrate(x.data(), step.data(), x.data());
    } else {
      control[direction - n].d = Lane(1.0);
    }
    system.evaluate(x.data(), control.data(), *data);
    const auto& d = static_cast<const MultibodySystem::Data<DL>&>(*data);
    for (int l = 0; l < kLaneWidth; ++l) {
      for (int i = 0; i < system.nv(); ++i) result[l](i, direction) = d.f[i].d[l];
      for (int i = 0; i < m; ++i) result[l](system.nv() + i, direction) = d.contacts.force[i].d[l];
    }
  }
  return result;
}

void expect_close(const MatrixXd& found, const MatrixXd& expected, const std::string& what) {
  ASSERT_TRUE(found.allFinite()) << what;
  const double scale = 1 + expected.lpNorm<Eigen::Infinity>();
  EXPECT_LE((found - expected).lpNorm<Eigen::Infinity>(), 1e-8 * scale) << what;
}

/// Compares all derivatives; returns true if the contacts of the first state are dependent.
bool expect_derivatives(const MultibodySystem& system, RandomNumbers& random) {
  const auto states = bending_states(system, random);
  std::vector<double> u(system.nu());
  for (double& a : u) a = random.uniform(-10, 10);
  const auto expected = dual_derivatives(system, states, u);
  const auto data = system.create_data(double{});
  const int nv = system.nv(), n = system.ndx(), m = system.contacts().rows();
  bool straight = false;
  for (int l = 0; l < kLaneWidth; ++l) {
    system.differentiate(states[l].data(), u.data(), *data);
    const auto& d = static_cast<const MultibodySystem::Data<double>&>(*data);
    if (l == 0) straight = d.contacts.compliant;
    const std::string lane =
        "lane " + std::to_string(l) + (d.contacts.compliant ? " with compliance, " : ", ");
    MatrixXd f(nv, n + system.nu());
    f.leftCols(n) = Map<const MatrixXd>(d.fx.data(), nv, n);
    f.rightCols(system.nu()) = Map<const MatrixXd>(d.fu.data(), nv, system.nu());
    expect_close(f, expected[l].topRows(nv), lane + "accelerations or velocities");
    expect_close(Map<const MatrixXd>(d.contacts.force_z.data(), m, f.cols()),
                 expected[l].bottomRows(m), lane + "forces or impulses");
  }
  return straight;
}

TEST(StraightLegs, DerivativesMatchTheCompliantSystem) {
  RandomNumbers random(53);
  int dependent = 0, independent = 0;
  for (const StraightCase& c : straight_cases()) {
    SCOPED_TRACE(c.name);
    const MultibodySystem system(c.robot, Actuation::full(*c.robot), {}, c.contacts);
    EXPECT_DOUBLE_EQ(system.contacts().compliance(), 1e-6 / c.robot->total_mass());
    (expect_derivatives(system, random) ? dependent : independent) += 1;
  }
  EXPECT_GE(dependent, 5);
  EXPECT_GE(independent, 5);
}

TEST(StraightLegs, ImpulseDerivativesIncludeTheCompliance) {
  RandomNumbers random(55);
  int dependent = 0;
  for (const StraightCase& c : straight_cases()) {
    SCOPED_TRACE(c.name);
    dependent += expect_derivatives(MultibodySystem(c.robot, c.contacts, 0.3), random);
  }
  EXPECT_GE(dependent, 5);
}

}  // namespace
}  // namespace conddp
