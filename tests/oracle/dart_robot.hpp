#pragma once

#include <string>
#include <vector>

#include <dart/dynamics/Skeleton.hpp>

#include "robot/model.hpp"
#include "support/robots.hpp"

namespace conddp {

/// The URDF as DART reads it, in the coordinates of our model. Joints are matched by name. DART's
/// free joint has positions (rotation vector, translation) and velocities (angular, linear).
/// Springs, damping, friction, and mimic joints are off, as in the model.
class DartRobot {
 public:
  DartRobot(const TestRobot& robot, const RobotModel& model);

  void set_state(const std::vector<double>& q, const std::vector<double>& v);
  Eigen::MatrixXd mass_matrix() const;
  /// Coriolis, centrifugal, and gravity forces.
  Eigen::VectorXd bias() const;
  Eigen::VectorXd forward_dynamics(const std::vector<double>& tau);
  void set_accelerations(const std::vector<double>& a);

  /// Links by name. Twists and accelerations are (linear, angular) in link axes.
  std::vector<std::string> links() const;
  Eigen::Isometry3d placement(const std::string& link) const;
  Eigen::VectorXd velocity(const std::string& link) const;
  Eigen::VectorXd acceleration(const std::string& link) const;
  /// Center of mass of the movable bodies.
  Eigen::Vector3d center_of_mass() const;

 private:
  Eigen::VectorXd to_dart(const std::vector<double>& velocity_like) const;
  Eigen::VectorXd from_dart(const Eigen::VectorXd& velocity_like) const;

  const RobotModel& model_;
  dart::dynamics::SkeletonPtr skeleton_;
  std::vector<int> dof_;  ///< DART index of each velocity index of the model
};

}  // namespace conddp
