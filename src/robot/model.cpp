#include "robot/model.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

namespace conddp {
namespace {

/// Prefixed names of a tree's joints and frames. A link and a joint of one tree may share a name;
/// two trees may not.
std::set<std::string> names_of(const RobotModel& tree, const std::string& prefix) {
  std::set<std::string> names;
  for (const Joint& joint : tree.joints) names.insert(prefix + joint.name);
  for (const Frame& frame : tree.frames) names.insert(prefix + frame.name);
  return names;
}

bool overlap(const std::set<std::string>& a, const std::set<std::string>& b) {
  return std::any_of(a.begin(), a.end(), [&](const std::string& name) { return b.contains(name); });
}

void make_distinct(RobotModel& tree, std::set<std::string>& taken) {
  std::string prefix;
  std::set<std::string> names = names_of(tree, prefix);
  for (int number = 1; overlap(names, taken); ++number) {
    prefix = tree.name + (number > 1 ? "_" + std::to_string(number) : "") + "/";
    names = names_of(tree, prefix);
  }
  for (Joint& joint : tree.joints) joint.name = prefix + joint.name;
  for (Frame& frame : tree.frames) frame.name = prefix + frame.name;
  taken.merge(names);
}

/// Moves elements to the end of `to` and applies `change` to each.
template <class T, class Change>
void append_changed(std::vector<T>& from, std::vector<T>& to, Change change) {
  for (T& element : from) {
    change(element);
    to.push_back(std::move(element));
  }
}

void append(RobotModel tree, RobotModel& all) {
  const int joints = all.joint_count();
  const int frames = static_cast<int>(all.frames.size());
  const auto shift = [&](int& joint) {
    if (joint >= 0) joint += joints;  // else it is the world
  };
  all.name += (all.name.empty() ? "" : "+") + tree.name;
  append_changed(tree.joints, all.joints, [&](Joint& joint) { shift(joint.parent); });
  append_changed(tree.frames, all.frames, [&](Frame& frame) { shift(frame.joint); });
  append_changed(tree.wrenches, all.wrenches,
                 [&](ExternalWrench& wrench) { wrench.frame += frames; });
  append_changed(tree.loads, all.loads, [&](Load& load) {
    shift(load.parameter);
    shift(load.body);
  });
  append_changed(tree.mimics, all.mimics, [&](Mimic& mimic) {
    shift(mimic.joint);
    shift(mimic.leader);
  });
}

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

RobotModel combine(std::vector<RobotModel> trees) {
  if (trees.empty()) throw std::logic_error("combine: no tree");
  RobotModel all;
  all.gravity = trees.front().gravity;
  std::set<std::string> taken;
  for (RobotModel& tree : trees) {
    if (squared_norm(tree.gravity - all.gravity) != 0)
      throw std::logic_error("combine: gravity differs between trees");
    make_distinct(tree, taken);
    append(std::move(tree), all);
  }
  all.finalize();
  return all;
}

}  // namespace conddp
