#include "robot/model.hpp"

#include <algorithm>
#include <stdexcept>

namespace conddp {
namespace {

/// Checks that joints are in depth-first order and that floating ones have the world as their
/// parent.
void check_order(const std::vector<Joint>& joints) {
  std::vector<int> path;
  for (int i = 0; i < static_cast<int>(joints.size()); ++i) {
    const Joint& joint = joints[i];
    while (!path.empty() && path.back() != joint.parent) path.pop_back();
    if (joint.parent >= 0 && path.empty())
      throw std::logic_error("joint " + joint.name + " does not follow its parent depth first");
    if (joint.type == JointType::floating && joint.parent >= 0)
      throw std::logic_error("floating joint " + joint.name + " does not hang on the world");
    path.push_back(i);
  }
}

/// For each degree of freedom, the index after the last one that it moves, from the parents.
std::vector<int> subtree_ends(const std::vector<int>& parents) {
  std::vector<int> ends(parents.size(), 0);
  for (int i = static_cast<int>(parents.size()) - 1; i >= 0; --i) {
    ends[i] = std::max(ends[i], i + 1);
    if (parents[i] >= 0) ends[parents[i]] = std::max(ends[parents[i]], ends[i]);
  }
  return ends;
}

}  // namespace

void RobotModel::finalize() {
  nq = nv = 0;
  parent_dof.clear();
  root.assign(joints.size(), -1);
  check_order(joints);
  for (int i = 0; i < joint_count(); ++i) {
    Joint& joint = joints[i];
    joint.q = nq;
    joint.v = nv;
    root[i] = joint.type == JointType::floating ? i : joint.parent >= 0 ? root[joint.parent] : -1;
    int parent = joint.parent < 0 ? -1 : joints[joint.parent].v + joints[joint.parent].nv() - 1;
    for (int k = 0; k < joint.nv(); ++k) {
      parent_dof.push_back(parent);
      parent = nv + k;
    }
    nq += joint.nq();
    nv += joint.nv();
  }
  subtree_end = subtree_ends(parent_dof);
}

int RobotModel::add_parameter(const std::string& parameter_name) {
  joints.push_back({.name = parameter_name, .type = JointType::parameter, .rotor_inertia = 1});
  finalize();
  return joint_count() - 1;
}

std::optional<int> RobotModel::find_joint(std::string_view joint_name) const {
  for (int i = 0; i < joint_count(); ++i)
    if (joints[i].name == joint_name) return i;
  return std::nullopt;
}

std::optional<int> RobotModel::find_frame(std::string_view frame_name) const {
  std::optional<int> found;
  for (int i = 0; i < static_cast<int>(frames.size()); ++i) {
    if (frames[i].name != frame_name) continue;
    if (frames[i].kind == FrameKind::link) return i;
    if (!found) found = i;
  }
  return found;
}

double RobotModel::total_mass() const {
  double mass = 0;
  for (const Joint& joint : joints) mass += joint.inertia.mass;
  return mass;
}

std::vector<double> RobotModel::neutral_configuration() const {
  std::vector<double> q(nq, 0.0);
  for (const Joint& joint : joints)
    if (joint.type == JointType::floating) q[joint.q + 6] = 1;
  return q;
}

}  // namespace conddp
