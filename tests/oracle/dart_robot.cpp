#include "oracle/dart_robot.hpp"

#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/DegreeOfFreedom.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/utils/urdf/DartLoader.hpp>
#include <urdf_parser/urdf_parser.h>

namespace conddp {
namespace {

std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return text.str();
}

/// Removes elements of this name, since DART would look for their meshes.
std::string without(std::string xml, const std::string& name) {
  const std::string end_tag = "</" + name + ">";
  for (std::size_t at = 0; (at = xml.find("<" + name, at)) != std::string::npos;) {
    const char next = xml[at + name.size() + 1];
    const std::size_t close = xml.find('>', at);
    if (next != '>' && next != ' ' && next != '/' && next != '\n') {
      at = close;
      continue;
    }
    const std::size_t end =
        xml[close - 1] == '/' ? close + 1 : xml.find(end_tag, at) + end_tag.size();
    xml.erase(at, end - at);
  }
  return xml;
}

/// Silences warnings of DART's loader about massless links.
class SilencedErrors {
 public:
  SilencedErrors() : stream_(std::cerr.rdbuf(nullptr)) {}
  ~SilencedErrors() { std::cerr.rdbuf(stream_); }
  SilencedErrors(const SilencedErrors&) = delete;
  SilencedErrors& operator=(const SilencedErrors&) = delete;

 private:
  std::streambuf* stream_;
};

bool is_free(const dart::dynamics::Joint& joint) {
  return dynamic_cast<const dart::dynamics::FreeJoint*>(&joint) != nullptr;
}

/// Converts (angular, linear) to (linear, angular).
Eigen::VectorXd swapped(const Eigen::Vector6d& twist) {
  Eigen::VectorXd m(6);
  m << twist.tail<3>(), twist.head<3>();
  return m;
}

}  // namespace

DartRobot::DartRobot(const TestRobot& robot, const RobotModel& model) : model_(model) {
  using dart::utils::DartLoader;
  const bool floating = robot.base == UrdfOptions::Base::floating;
  DartLoader loader(
      {nullptr, floating ? DartLoader::RootJointType::FLOATING : DartLoader::RootJointType::FIXED});
  const std::string xml = without(without(read_file(robot.urdf), "visual"), "collision");
  {
    const SilencedErrors silence;
    skeleton_ = loader.parseSkeletonString(xml, dart::common::Uri("file:///"));
  }
  if (!skeleton_) throw std::runtime_error("DART cannot read " + robot.urdf.string());
  skeleton_->setGravity({model.gravity.x, model.gravity.y, model.gravity.z});
  const auto file = urdf::parseURDF(xml);
  for (dart::dynamics::BodyNode* body : skeleton_->getBodyNodes()) {
    // DART assigns a default inertia to links without one and warns about exact zeros.
    if (!file->getLink(body->getName())->inertial)
      body->setInertia(dart::dynamics::Inertia(1e-20, Eigen::Vector3d::Zero(),
                                               1e-20 * Eigen::Matrix3d::Identity()));
  }
  for (dart::dynamics::Joint* joint : skeleton_->getJoints())
    joint->setActuatorType(dart::dynamics::Joint::FORCE);
  for (dart::dynamics::DegreeOfFreedom* dof : skeleton_->getDofs()) {
    dof->setDampingCoefficient(0);
    dof->setSpringStiffness(0);
    dof->setCoulombFriction(0);
  }
  if (static_cast<int>(skeleton_->getNumDofs()) != model.nv)
    throw std::runtime_error("DART counts other degrees of freedom in " + robot.urdf.string());
  for (const Joint& joint : model.joints) {
    if (joint.type == JointType::floating) {
      if (!is_free(*skeleton_->getRootJoint())) throw std::runtime_error("no free joint in DART");
      for (const int k : {3, 4, 5, 0, 1, 2})
        dof_.push_back(static_cast<int>(skeleton_->getRootJoint()->getIndexInSkeleton(k)));
    } else {
      dof_.push_back(static_cast<int>(skeleton_->getJoint(joint.name)->getIndexInSkeleton(0)));
    }
  }
}

Eigen::VectorXd DartRobot::to_dart(const std::vector<double>& velocity_like) const {
  Eigen::VectorXd out(model_.nv);
  for (int i = 0; i < model_.nv; ++i) out[dof_[i]] = velocity_like[i];
  return out;
}

Eigen::VectorXd DartRobot::from_dart(const Eigen::VectorXd& velocity_like) const {
  Eigen::VectorXd out(model_.nv);
  for (int i = 0; i < model_.nv; ++i) out[i] = velocity_like[dof_[i]];
  return out;
}

void DartRobot::set_state(const std::vector<double>& q, const std::vector<double>& v) {
  Eigen::VectorXd positions(model_.nv);
  for (const Joint& joint : model_.joints) {
    const double* x = &q[joint.q];
    if (joint.type == JointType::floating) {
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.linear() = Eigen::Quaterniond(x[6], x[3], x[4], x[5]).toRotationMatrix();
      pose.translation() << x[0], x[1], x[2];
      const Eigen::Vector6d free = dart::dynamics::FreeJoint::convertToPositions(pose);
      const std::size_t first = skeleton_->getRootJoint()->getIndexInSkeleton(0);
      positions.segment<6>(static_cast<Eigen::Index>(first)) = free;
    } else {
      positions[dof_[joint.v]] = x[0];
    }
  }
  skeleton_->setPositions(positions);
  skeleton_->setVelocities(to_dart(v));
}

Eigen::MatrixXd DartRobot::mass_matrix() const {
  const Eigen::MatrixXd& theirs = skeleton_->getMassMatrix();
  Eigen::MatrixXd ours(model_.nv, model_.nv);
  for (int i = 0; i < model_.nv; ++i)
    for (int j = 0; j < model_.nv; ++j) ours(i, j) = theirs(dof_[i], dof_[j]);
  return ours;
}

Eigen::VectorXd DartRobot::bias() const {
  return from_dart(skeleton_->getCoriolisAndGravityForces());
}

Eigen::VectorXd DartRobot::forward_dynamics(const std::vector<double>& tau) {
  skeleton_->setForces(to_dart(tau));
  skeleton_->computeForwardDynamics();
  return from_dart(skeleton_->getAccelerations());
}

void DartRobot::set_accelerations(const std::vector<double>& a) {
  skeleton_->setAccelerations(to_dart(a));
}

std::vector<std::string> DartRobot::links() const {
  std::vector<std::string> names;
  for (const dart::dynamics::BodyNode* body : skeleton_->getBodyNodes())
    names.push_back(body->getName());
  return names;
}

Eigen::Isometry3d DartRobot::placement(const std::string& link) const {
  return skeleton_->getBodyNode(link)->getWorldTransform();
}

Eigen::Vector3d DartRobot::center_of_mass() const {
  double mass = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (const dart::dynamics::BodyNode* body : skeleton_->getBodyNodes()) {
    if (body->getNumDependentGenCoords() == 0) continue;
    mass += body->getMass();
    moment += body->getMass() * body->getCOM();
  }
  return moment / mass;
}

Eigen::VectorXd DartRobot::velocity(const std::string& link) const {
  return swapped(skeleton_->getBodyNode(link)->getSpatialVelocity());
}

Eigen::VectorXd DartRobot::acceleration(const std::string& link) const {
  return swapped(skeleton_->getBodyNode(link)->getSpatialAcceleration());
}

}  // namespace conddp
