#include "problem_file/motion/quasi_static.hpp"

#include <algorithm>

#include <Eigen/Dense>

#include "robot/dynamics.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

namespace {

/// The smallest controls and contact forces that hold a robot at rest: B u + Jᵀ λ = g(q).
Eigen::VectorXd hold_at_rest(const MultibodySystem& system, const double* x) {
  const RobotModel& robot = system.robot();
  const std::vector<double> zero(robot.nv, 0.0);
  const int nv = system.nv(), nu = system.nu(), m = system.contacts().rows();
  MultibodySystem::Data<double> data(system);
  const std::vector<double> q = system.expand_configuration(std::vector(x, x + system.nq()));
  inverse_dynamics(robot, q.data(), zero.data(), zero.data(), data.robot);
  const std::vector<double> load =
      system.reduce_force(std::vector(data.robot.tau.begin(), data.robot.tau.end()));
  system.contacts().update(robot, data.robot, nv, data.contacts);  // Jᵀ into `response`
  Eigen::MatrixXd forces(nv, nu + m);
  forces << Eigen::Map<const Eigen::MatrixXd>(system.actuation().B.data(), nv, nu),
      Eigen::Map<const Eigen::MatrixXd>(data.contacts.response.data(), nv, m);
  const Eigen::VectorXd found = forces.completeOrthogonalDecomposition().solve(
      Eigen::Map<const Eigen::VectorXd>(load.data(), nv));
  return found.head(nu);
}

}  // namespace

Eigen::VectorXd quasi_static_control(const System& system, const double* x) {
  const int nu = system.nu();
  if (nu == 0) return {};
  if (const auto* multibody = system.as_multibody()) return hold_at_rest(*multibody, x);
  if (system.kind() != SystemKind::second_order) return Eigen::VectorXd::Zero(nu);
  std::vector<double> rest(x, x + system.nx());
  std::fill(rest.begin() + system.nq(), rest.end(), 0.0);
  const std::vector<double> none(nu, 0.0);
  const auto data = system.create_data(double{});
  system.differentiate(rest.data(), none.data(), *data);
  const Eigen::Map<const Eigen::MatrixXd> fu(data->fu.data(), system.rows(), nu);
  const Eigen::Map<const Eigen::VectorXd> f(data->f.data(), system.rows());
  return -fu.completeOrthogonalDecomposition().solve(Eigen::VectorXd(f));
}

}  // namespace conddp
