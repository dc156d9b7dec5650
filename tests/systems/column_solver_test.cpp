// Accelerations and forces along tree branches, compared with one dense system without tree
// structure.
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "support/contact_case.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Data = MultibodySystem::Data<double>;

/// Columns of [M −Jᵀ; J ε]⁻¹ [−∂tau/∂z + B; −∂c/∂z].
MatrixXd dense_columns(const MultibodySystem& system, const Data& data) {
  const int n = system.nv(), m = system.contacts().rows(), nu = system.nu();
  MatrixXd kkt = MatrixXd::Zero(n + m, n + m), rhs = MatrixXd::Zero(n + m, 2 * n + nu);
  kkt.topLeftCorner(n, n) =
      Map<const MatrixXd>(data.robot.M.data(), n, n).selfadjointView<Eigen::Lower>();
  rhs.topLeftCorner(n, n) = -Map<const MatrixXd>(data.robot.tau_q.data(), n, n);
  rhs.block(0, n, n, n) = -Map<const MatrixXd>(data.robot.tau_v.data(), n, n);
  rhs.topRightCorner(n, nu) = Map<const MatrixXd>(system.actuation().B.data(), n, nu);
  for (int i = 0; i < system.contacts().count(); ++i) {
    const ContactData<double>& contact = data.contacts.contacts[i];
    const std::vector<int>& columns = system.contacts().columns(i);
    const int rows = system.contacts().contacts()[i].rows(), at = n + system.contacts().offset(i);
    for (std::size_t c = 0; c < columns.size(); ++c)
      for (int r = 0; r < rows; ++r) {
        kkt(at + r, columns[c]) = contact.jacobian[c * rows + r];
        kkt(columns[c], at + r) = -contact.jacobian[c * rows + r];
        rhs(at + r, columns[c]) = -contact.wrt_q[c * rows + r];
        rhs(at + r, n + columns[c]) = -contact.wrt_v[c * rows + r];
      }
  }
  if (m > 0 && data.contacts.compliant)
    kkt.bottomRightCorner(m, m).diagonal().setConstant(system.contacts().compliance());
  return kkt.fullPivLu().solve(rhs);
}

void expect_dense_columns(const MultibodySystem& system, RandomNumbers& random) {
  const RobotState s = random_state(system.robot(), random);
  std::vector<double> x = s.q, u(system.nu());
  x.insert(x.end(), s.v.begin(), s.v.end());
  for (double& a : u) a = random.uniform(-10, 10);
  Data data(system);
  data.f.resize(system.rows());
  data.fx.resize(system.rows() * system.ndx());
  data.fu.resize(system.rows() * system.nu());
  system.differentiate(x.data(), u.data(), data);
  const int n = system.nv(), m = system.contacts().rows();
  const MatrixXd expected = dense_columns(system, data);
  const double tolerance = m > 0 && data.contacts.compliant ? 1e-6 : 1e-9;
  const auto expect_near = [&](const MatrixXd& found, const MatrixXd& figure, const char* what) {
    if (figure.size() == 0) return;
    EXPECT_LT((found - figure).lpNorm<Eigen::Infinity>(),
              tolerance * (1 + figure.lpNorm<Eigen::Infinity>()))
        << what;
  };
  expect_near(Map<const MatrixXd>(data.fx.data(), n, 2 * n), expected.topLeftCorner(n, 2 * n),
              "fx");
  expect_near(Map<const MatrixXd>(data.fu.data(), n, system.nu()),
              expected.topRightCorner(n, system.nu()), "fu");
  expect_near(Map<const MatrixXd>(data.contacts.force_z.data(), m, 2 * n + system.nu()),
              expected.bottomRows(m), "force_z");
}

TEST(ColumnSolver, MatchesTheDenseSystemOfHeldRobots) {
  RandomNumbers random(41);
  for (const ContactCase& c : contact_cases()) {
    if (!c.robot->mimics.empty()) continue;
    SCOPED_TRACE(c.name);
    expect_dense_columns(MultibodySystem(c.robot, Actuation::full(*c.robot), {}, c.contacts),
                         random);
  }
}

TEST(ColumnSolver, MatchesTheDenseSystemOfFreeRobots) {
  RandomNumbers random(42);
  for (const TestModel& r : random_robots()) {
    SCOPED_TRACE(r.name);
    const auto robot = std::make_shared<RobotModel>(r.model);
    expect_dense_columns(MultibodySystem(robot, Actuation::full(*robot)), random);
  }
}

}  // namespace
}  // namespace conddp
