#include "problem_file/motion/loop_closure.hpp"

#include <cmath>

#include <Eigen/Dense>
#include <fmt/format.h>

namespace conddp {

LoopClosure::LoopClosure(const MultibodySystem& system, const std::vector<double>& x)
    : system_(system), data_(system), x_(x.begin(), x.begin() + system.nx()), start_(x_) {
  linearize();
  gaps_ = gaps_now();
  constexpr int kMostSteps = 50;
  constexpr double kClosed = 1e-9, kLongest = 0.5;  // m and rad
  for (int i = 0; i < kMostSteps && error_.norm() > kClosed; ++i) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(system.ndx());
    step.head(system.nv()) = -jacobian_.completeOrthogonalDecomposition().solve(error_);
    step *= std::min(1.0, kLongest / step.norm());
    system.manifold().integrate(x_.data(), step.data(), x_.data());
    linearize();
  }
  if (!(error_.norm() <= kClosed)) x_.clear();
}

void LoopClosure::linearize() {
  system_.update_kinematics(x_.data(), data_);
  const ContactSet& set = system_.contacts();
  const int n = system_.nv();
  set.update(system_.robot(), data_.robot, n, data_.contacts);
  error_.resize(set.rows());
  for (int i = 0; i < set.count(); ++i)
    contact_error(set.contacts()[i], data_.contacts.contacts[i], &error_[set.offset(i)]);
  jacobian_ =
      Eigen::Map<const Eigen::MatrixXd>(data_.contacts.response.data(), n, set.rows()).transpose();
  // Bodies that float stay where they are.
  for (int j = 0; j < system_.robot().joint_count(); ++j)
    if (const Joint& joint = system_.robot().joints[j]; joint.type == JointType::floating)
      jacobian_.middleCols(*system_.velocity_row(j), joint.nv()).setZero();
}

std::vector<double> LoopClosure::gaps_now() const {
  std::vector<double> gaps;
  const ContactSet& set = system_.contacts();
  for (int i = 0; i < set.count(); ++i)
    gaps.push_back(error_.segment(set.offset(i), set.contacts()[i].rows()).norm());
  return gaps;
}

std::string LoopClosure::closed_joints() const {
  if (x_.empty()) return "";
  std::string list;
  const RobotModel& robot = system_.robot();
  for (int j = 0; j < robot.joint_count(); ++j) {
    const auto at = system_.position_index(j);
    if (!at || robot.joints[j].nq() != 1 || std::abs(x_[*at] - start_[*at]) < 1e-7) continue;
    list += fmt::format("{}{}: {:.7g}", list.empty() ? "{" : ", ", robot.joints[j].name, x_[*at]);
  }
  return list.empty() ? list : list + "}";
}

}  // namespace conddp
