#include "problem_file/motion/loop_closure.hpp"

#include <cmath>

#include <Eigen/Dense>
#include <fmt/format.h>

namespace conddp {
namespace {

/// The errors of a system's contacts as functions of the configuration.
class LoopErrors {
 public:
  explicit LoopErrors(const MultibodySystem& system) : system_(system), data_(system) {}

  /// Errors, one row after another.
  Eigen::VectorXd at(const std::vector<double>& x) {
    system_.update_kinematics(x.data(), data_);
    const ContactSet& set = system_.contacts();
    set.update(system_.robot(), data_.robot, system_.nv(), data_.contacts);
    Eigen::VectorXd errors(set.rows());
    for (int i = 0; i < set.count(); ++i)
      contact_error(set.contacts()[i], data_.contacts.contacts[i], &errors[set.offset(i)]);
    return errors;
  }
  /// Their Jacobian in the last state (rows x nv), without the columns of floating bodies.
  Eigen::MatrixXd jacobian() const {
    const Eigen::Map<const Eigen::MatrixXd> transposed(data_.contacts.response.data(), system_.nv(),
                                                       system_.contacts().rows());
    Eigen::MatrixXd jacobian = transposed.transpose();
    for (int j = 0; j < system_.robot().joint_count(); ++j)
      if (const Joint& joint = system_.robot().joints[j]; joint.type == JointType::floating)
        jacobian.middleCols(*system_.velocity_row(j), joint.nv()).setZero();
    return jacobian;
  }

 private:
  const MultibodySystem& system_;
  MultibodySystem::Data<double> data_;
};

/// The state with closed loops next to x; empty if there is none.
std::vector<double> closed_state(const MultibodySystem& system, std::vector<double> x) {
  constexpr int kMostSteps = 50;
  constexpr double kClosed = 1e-9, kLongest = 0.5;  // m and rad
  LoopErrors errors(system);
  Eigen::VectorXd error = errors.at(x);
  for (int i = 0; i < kMostSteps && error.norm() > kClosed; ++i) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(system.ndx());
    step.head(system.nv()) = -errors.jacobian().completeOrthogonalDecomposition().solve(error);
    if (step.norm() > kLongest) step *= kLongest / step.norm();
    system.manifold().integrate(x.data(), step.data(), x.data());
    error = errors.at(x);
  }
  if (!(error.norm() <= kClosed)) x.clear();
  return x;
}

}  // namespace

std::vector<double> loop_gaps(const MultibodySystem& system, const std::vector<double>& x) {
  const Eigen::VectorXd error = LoopErrors(system).at(x);
  std::vector<double> gaps;
  const ContactSet& set = system.contacts();
  for (int i = 0; i < set.count(); ++i)
    gaps.push_back(error.segment(set.offset(i), set.contacts()[i].rows()).norm());
  return gaps;
}

std::string closing_joints(const MultibodySystem& system, const std::vector<double>& x) {
  const std::vector<double> closed =
      closed_state(system, std::vector(x.begin(), x.begin() + system.nx()));
  std::string list;
  const RobotModel& robot = system.robot();
  for (int j = 0; j < robot.joint_count() && !closed.empty(); ++j) {
    const auto at = system.position_index(j);
    if (!at || robot.joints[j].nq() != 1 || std::abs(closed[*at] - x[*at]) < 1e-7) continue;
    list +=
        fmt::format("{}{}: {:.7g}", list.empty() ? "{" : ", ", robot.joints[j].name, closed[*at]);
  }
  return list.empty() ? list : list + "}";
}

}  // namespace conddp
