#include "robot/urdf/urdf_topology.hpp"

#include <algorithm>
#include <unordered_map>

#include "base/text/spelling.hpp"

namespace conddp {
namespace {

struct LinkEntry {
  std::string name;
  int element = 0;
  int parent_joint = -1;  ///< index among the joints
  std::vector<int> child_joints;
};
struct JointEntry {
  std::string name;
  std::string type;
  int element = 0;
  int parent = -1;  ///< index among the links
  int child = -1;
  std::string leader;  ///< joint that a mimic joint follows
};

class Topology {
 public:
  Topology(const XmlOutline& outline, const UrdfOptions& options, UrdfReport& report)
      : outline_(outline), options_(options), report_(report) {}

  void check() {
    collect_links();
    collect_joints();
    check_mimics();
    if (!report_.has_errors()) walk();
  }

 private:
  using Index = std::unordered_map<std::string, int>;

  std::optional<std::string> name_of(int element, const Index& known) {
    const XmlElement& e = outline_.elements[element];
    const std::string tag(e.tag);
    const auto name = e.attribute("name");
    if (!name) {
      report_.error_at(element, "", "a " + tag + " has no name");
      return std::nullopt;
    }
    if (known.contains(std::string(*name))) {
      report_.error_at(element, std::string(*name),
                       tag + " '" + std::string(*name) + "': a second " + tag + " of this name");
      return std::nullopt;
    }
    return std::string(*name);
  }

  void collect_links() {
    for (const int element : outline_.children(0, "link")) {
      const auto name = name_of(element, link_index_);
      if (!name) continue;
      link_index_[*name] = static_cast<int>(links_.size());
      link_names_.push_back(*name);
      links_.push_back({*name, element, -1, {}});
    }
  }

  void collect_joints() {
    for (const int element : outline_.children(0, "joint")) {
      const auto name = name_of(element, joint_index_);
      if (!name) continue;
      const int index = static_cast<int>(joints_.size());
      joint_index_[*name] = index;
      joint_names_.push_back(*name);
      JointEntry joint{*name,
                       std::string(outline_.elements[element].attribute("type").value_or("")),
                       element,
                       link_of(*name, element, "parent"),
                       link_of(*name, element, "child"),
                       {}};
      check_type(joint);
      if (const auto mimic = outline_.child(element, "mimic"))
        joint.leader = outline_.elements[*mimic].attribute("joint").value_or("");
      if (joint.child >= 0) attach(index, joint);
      if (joint.parent >= 0) links_[joint.parent].child_joints.push_back(index);
      joints_.push_back(std::move(joint));
    }
  }

  void check_type(const JointEntry& joint) {
    static const std::vector<std::string> kTypes{"revolute", "continuous", "prismatic",
                                                 "fixed",    "floating",   "planar"};
    if (std::find(kTypes.begin(), kTypes.end(), joint.type) != kTypes.end()) return;
    report_.error_at(joint.element, joint.name,
                     "joint '" + joint.name + "': " +
                         (joint.type.empty() ? "has no type" : "unknown type '" + joint.type + "'"),
                     name_hint(joint.type, kTypes, "types"));
  }

  int link_of(const std::string& joint, int element, std::string_view side) {
    const auto child = outline_.child(element, side);
    const auto link = child ? outline_.elements[*child].attribute("link") : std::nullopt;
    const std::string subject = "joint '" + joint + "': ";
    if (!link) {
      report_.error_at(child.value_or(element), joint,
                       subject + "has no " + std::string(side) + " link",
                       "write <" + std::string(side) + " link=\"...\"/>");
      return -1;
    }
    if (const auto found = link_index_.find(std::string(*link)); found != link_index_.end())
      return found->second;
    // Edit distances from thousands of wrong names to thousands of links would take minutes.
    constexpr int kHints = 20;
    report_.error_at(
        *child, joint,
        subject + std::string(side) + " link '" + std::string(*link) + "' does not exist",
        hints_++ < kHints ? name_hint(*link, link_names_, "links") : "");
    return -1;
  }

  void attach(int index, const JointEntry& joint) {
    LinkEntry& child = links_[joint.child];
    if (joint.parent == joint.child)
      return report_.error_at(
          joint.element, joint.name,
          "joint '" + joint.name + "': link '" + child.name + "' is parent and child");
    if (child.parent_joint >= 0)
      return report_.error_at(joint.element, child.name,
                              "link '" + child.name + "': has two parents, through joints '" +
                                  joints_[child.parent_joint].name + "' and '" + joint.name + "'",
                              "closed kinematic loops are not supported: a URDF is a tree");
    child.parent_joint = index;
  }

  void check_mimics() {
    for (const JointEntry& joint : joints_)
      if (const auto mimic = outline_.child(joint.element, "mimic")) check_mimic(joint, *mimic);
  }

  void check_mimic(const JointEntry& joint, int mimic) {
    if (joint.leader.empty()) {
      report_.error_at(mimic, joint.name, "joint '" + joint.name + "': <mimic> names no joint");
    } else if (joint.leader == joint.name) {
      report_mimic(mimic, joint, "mimics itself");
    } else if (!joint_index_.contains(joint.leader)) {
      report_mimic(mimic, joint, "mimics '" + joint.leader + "', which does not exist",
                   name_hint(joint.leader, joint_names_, "joints"));
    } else if (follows_itself(joint)) {
      report_mimic(mimic, joint, "mimic joints follow each other in a cycle");
    }
  }

  /// An error if mimic joints follow their leaders, otherwise a warning.
  void report_mimic(int element, const JointEntry& joint, const std::string& message,
                    std::string hint = {}) {
    const std::string whole = "joint '" + joint.name + "': " + message;
    if (options_.enforce_mimic)
      report_.error_at(element, joint.name, whole, std::move(hint));
    else
      report_.warning_at(element, joint.name, whole + "; it is independent");
  }

  bool follows_itself(const JointEntry& joint) const {
    std::string leader = joint.leader;
    for (std::size_t steps = 0; steps <= joints_.size(); ++steps) {
      if (leader == joint.name) return true;
      const auto found = joint_index_.find(leader);
      if (found == joint_index_.end()) return false;
      leader = joints_[found->second].leader;
    }
    return false;
  }

  /// Checks for exactly one root and that every link can be reached from it.
  void walk() {
    const std::vector<int> roots = find_roots();
    if (roots.size() > 1) return report_parts(roots);
    if (const auto missed = find_unreached(roots)) report_loop(*missed);
  }

  std::vector<int> find_roots() const {
    std::vector<int> roots;
    for (int i = 0; i < static_cast<int>(links_.size()); ++i)
      if (links_[i].parent_joint < 0) roots.push_back(i);
    return roots;
  }

  void report_parts(const std::vector<int>& roots) {
    std::vector<std::string> names;
    for (const int root : roots) names.push_back(links_[root].name);
    report_.error_at(links_[roots[1]].element, names[1],
                     "the file has " + std::to_string(roots.size()) +
                         " separate parts, with the root links " + listed(names),
                     "connect them by joints, or give each tree a file of its own");
  }

  /// First link that cannot be reached from the root; it belongs to a loop or hangs on one.
  std::optional<int> find_unreached(std::vector<int> open) const {
    std::vector<char> visited(links_.size(), 0);
    while (!open.empty()) {
      const int link = open.back();
      open.pop_back();
      visited[link] = 1;
      for (const int joint : links_[link].child_joints) open.push_back(joints_[joint].child);
    }
    const auto missed = std::find(visited.begin(), visited.end(), 0);
    if (missed == visited.end()) return std::nullopt;
    return static_cast<int>(missed - visited.begin());
  }

  void report_loop(int link) {
    std::vector<char> seen(links_.size(), 0);
    const auto parent = [&](int i) { return joints_[links_[i].parent_joint].parent; };
    while (!seen[link]) {
      seen[link] = 1;
      link = parent(link);
    }
    std::vector<std::string> names;
    int at = link;
    do {
      names.push_back(links_[at].name);
      at = parent(at);
    } while (at != link);
    std::reverse(names.begin(), names.end());
    report_.error_at(
        links_[link].element, links_[link].name,
        "link '" + links_[link].name + "': the links " + listed(names) + " form a loop",
        "closed kinematic loops are not supported: a URDF is a tree");
  }

  const XmlOutline& outline_;
  const UrdfOptions& options_;
  UrdfReport& report_;
  std::vector<LinkEntry> links_;
  std::vector<JointEntry> joints_;
  Index link_index_, joint_index_;
  int hints_ = 0;  ///< number of hints given for links that do not exist
  std::vector<std::string> link_names_, joint_names_;
};

}  // namespace

void check_urdf_topology(const XmlOutline& outline, const UrdfOptions& options,
                         UrdfReport& report) {
  Topology(outline, options, report).check();
}

}  // namespace conddp
