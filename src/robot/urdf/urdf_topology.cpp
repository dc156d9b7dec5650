#include "robot/urdf/urdf_topology.hpp"

#include <algorithm>
#include <unordered_map>

#include <fmt/format.h>

#include "base/text/spelling.hpp"

namespace conddp {
namespace {

/// Elements with one tag by their names, which are unique.
struct NamedElements {
  std::vector<pugi::xml_node> nodes;
  std::vector<std::string> names;
  std::unordered_map<std::string, int> index;

  int find(const std::string& name) const {
    const auto found = index.find(name);
    return found == index.end() ? -1 : found->second;
  }
};

NamedElements collect(pugi::xml_node robot, const char* tag, UrdfReport& report) {
  NamedElements found;
  for (const pugi::xml_node element : robot.children(tag)) {
    const std::string name = element.attribute("name").value();
    if (!element.attribute("name")) {
      report.error({element}, fmt::format("a {} has no name", tag));
    } else if (!found.index.emplace(name, found.nodes.size()).second) {
      report.error(report.around(element), fmt::format("a second {} of this name", tag));
    } else {
      found.nodes.push_back(element);
      found.names.push_back(name);
    }
  }
  return found;
}

class Topology {
 public:
  Topology(pugi::xml_node robot, const UrdfOptions& options, UrdfReport& report)
      : options_(options),
        report_(report),
        links_(collect(robot, "link", report)),
        joints_(collect(robot, "joint", report)),
        above_(links_.nodes.size()) {}

  void check() {
    for (const pugi::xml_node joint : joints_.nodes) check_joint(joint);
    for (const pugi::xml_node joint : joints_.nodes)
      if (joint.child("mimic")) check_mimic(joint);
    if (!report_.has_errors()) check_tree();
  }

 private:
  /// Indices of a link's parent joint and parent link.
  struct Above {
    int joint = -1;
    int link = -1;
  };

  void check_joint(pugi::xml_node joint) {
    const int parent = link_of(joint, "parent"), child = link_of(joint, "child");
    check_type(joint);
    if (child < 0) return;
    const std::string& name = links_.names[child];
    const std::string joint_name = joint.attribute("name").value();
    if (parent == child)
      return report_.error(report_.around(joint),
                           fmt::format("link '{}' is parent and child", name));
    if (const int other = above_[child].joint; other >= 0)
      return report_.error({joint, name, fmt::format("link '{}': ", name)},
                           fmt::format("has two parents, through joints '{}' and '{}'",
                                       joints_.names[other], joint_name),
                           kNoLoops);
    above_[child] = {joints_.find(joint_name), parent};
  }

  void check_type(pugi::xml_node joint) {
    static const std::vector<std::string> kTypes{"revolute", "continuous", "prismatic",
                                                 "fixed",    "floating",   "planar"};
    const std::string type = joint.attribute("type").value();
    if (std::find(kTypes.begin(), kTypes.end(), type) != kTypes.end()) return;
    report_.error(report_.around(joint),
                  type.empty() ? "has no type" : fmt::format("unknown type '{}'", type),
                  name_hint(type, kTypes, "types"));
  }

  /// Index of a joint's parent or child link, or −1 and an error.
  int link_of(pugi::xml_node joint, const char* side) {
    const pugi::xml_node element = joint.child(side);
    const std::string link = element.attribute("link").value();
    if (!element.attribute("link")) {
      report_.error(report_.around(element ? element : joint), fmt::format("has no {} link", side),
                    fmt::format("write <{} link=\"...\"/>", side));
      return -1;
    }
    const int found = links_.find(link);
    // Edit distances from thousands of wrong names to thousands of links would take minutes.
    constexpr int kHints = 20;
    if (found < 0)
      report_.error(report_.around(element), fmt::format("{} link '{}' does not exist", side, link),
                    hints_++ < kHints ? name_hint(link, links_.names, "links") : "");
    return found;
  }

  static std::string leader_of(pugi::xml_node joint) {
    return joint.child("mimic").attribute("joint").value();
  }

  void check_mimic(pugi::xml_node joint) {
    const std::string leader = leader_of(joint);
    if (leader.empty())
      report_.error(report_.around(joint.child("mimic")), "<mimic> names no joint");
    else if (leader == joint.attribute("name").value())
      report_mimic(joint, "mimics itself");
    else if (joints_.find(leader) < 0)
      report_mimic(joint, fmt::format("mimics '{}', which does not exist", leader),
                   name_hint(leader, joints_.names, "joints"));
    else if (follows_itself(joint))
      report_mimic(joint, "mimic joints follow each other in a cycle");
  }

  /// An error if mimic joints follow their leaders, otherwise a warning.
  void report_mimic(pugi::xml_node joint, const std::string& message, std::string hint = {}) {
    const UrdfPlace place = report_.around(joint.child("mimic"));
    if (options_.enforce_mimic)
      report_.error(place, message, std::move(hint));
    else
      report_.warning(place, message + "; it is independent");
  }

  bool follows_itself(pugi::xml_node joint) const {
    int leader = joints_.find(leader_of(joint));
    for (std::size_t steps = 0; leader >= 0 && steps < joints_.nodes.size(); ++steps) {
      if (joints_.nodes[leader] == joint) return true;
      leader = joints_.find(leader_of(joints_.nodes[leader]));
    }
    return false;
  }

  /// Checks for exactly one root and that every link hangs on it.
  void check_tree() {
    std::vector<std::string> roots;
    for (std::size_t i = 0; i < links_.nodes.size(); ++i)
      if (above_[i].link < 0) roots.push_back(links_.names[i]);
    if (roots.size() > 1)
      return report_.error({links_.nodes[links_.find(roots[1])], roots[1]},
                           fmt::format("the file has {} separate parts, with the root links {}",
                                       roots.size(), listed(roots)),
                           "connect them by joints, or give each tree a file of its own");
    // The way up from a link ends at the root, at a link of an earlier way, or in a loop.
    std::vector<int> way(links_.nodes.size(), -1);
    for (int start = 0; start < static_cast<int>(way.size()); ++start) {
      int link = start;
      for (; link >= 0 && way[link] < 0; link = above_[link].link) way[link] = start;
      if (link >= 0 && way[link] == start) return report_loop(link);
    }
  }

  void report_loop(int link) {
    std::vector<std::string> names;
    int at = link;
    do {
      names.push_back(links_.names[at]);
      at = above_[at].link;
    } while (at != link);
    std::reverse(names.begin(), names.end());
    report_.error(report_.around(links_.nodes[link]),
                  fmt::format("the links {} form a loop", listed(names)), kNoLoops);
  }

  static constexpr const char* kNoLoops =
      "closed kinematic loops are not supported: a URDF is a tree";

  const UrdfOptions& options_;
  UrdfReport& report_;
  NamedElements links_, joints_;
  std::vector<Above> above_;  ///< of each link
  int hints_ = 0;             ///< number of hints given for links that do not exist
};

}  // namespace

void check_urdf_topology(pugi::xml_node robot, const UrdfOptions& options, UrdfReport& report) {
  Topology(robot, options, report).check();
}

}  // namespace conddp
