#include <algorithm>

#include <Eigen/Dense>

#include "problem_file/guess_builder.hpp"
#include "robot/dynamics.hpp"

namespace conddp {

Eigen::VectorXd quasi_static_control(const Plant& plant, const double* x) {
  const System& system = *plant.system;
  const int nu = system.nu();
  if (nu == 0) return {};
  if (plant.multibody) {
    const RobotModel& robot = plant.robot();
    const std::vector<double> zero(robot.nv, 0.0);
    RobotData<double> data(robot);
    const std::vector<double> q =
        plant.multibody->expand_configuration(std::vector(x, x + system.nq()));
    inverse_dynamics(robot, q.data(), zero.data(), zero.data(), data);
    const std::vector<double> reduced =
        plant.multibody->reduce_force(std::vector(data.tau.begin(), data.tau.end()));
    const int nv = system.nv();
    const Eigen::Map<const Eigen::MatrixXd> B(plant.multibody->actuation().B.data(), nv, nu);
    const Eigen::Map<const Eigen::VectorXd> load(reduced.data(), nv);
    return B.completeOrthogonalDecomposition().solve(load);
  }
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
