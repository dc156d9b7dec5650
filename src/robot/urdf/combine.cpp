#include "robot/urdf/combine.hpp"

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

}  // namespace

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
