#include "robot/urdf/urdf_document.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <set>
#include <sstream>
#include <unordered_map>

#include <fmt/format.h>
#include <fmt/ranges.h>

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

/// Attribute of an element that is read. `numbers` > 0: its value is that many finite numbers.
struct AttributeRule {
  std::string_view name;
  int numbers = 0;
};
struct ElementRule {
  std::string_view parent;  ///< tag of the enclosing element
  std::string_view tag;
  std::vector<AttributeRule> attributes;
};

const std::vector<ElementRule>& rules() {
  static const std::vector<ElementRule> table{
      {"robot", "link", {{"name"}}},
      {"robot", "joint", {{"name"}, {"type"}}},
      {"link", "inertial", {}},
      {"inertial", "origin", {{"xyz", 3}, {"rpy", 3}}},
      {"inertial", "mass", {{"value", 1}}},
      {"inertial",
       "inertia",
       {{"ixx", 1}, {"ixy", 1}, {"ixz", 1}, {"iyy", 1}, {"iyz", 1}, {"izz", 1}}},
      {"joint", "origin", {{"xyz", 3}, {"rpy", 3}}},
      {"joint", "parent", {{"link"}}},
      {"joint", "child", {{"link"}}},
      {"joint", "axis", {{"xyz", 3}}},
      {"joint", "limit", {{"lower", 1}, {"upper", 1}, {"effort", 1}, {"velocity", 1}}},
      {"joint", "dynamics", {{"damping", 1}, {"friction", 1}}},
      {"joint", "mimic", {{"joint"}, {"multiplier", 1}, {"offset", 1}}},
  };
  return table;
}

const ElementRule* find_rule(std::string_view parent, std::string_view tag) {
  for (const ElementRule& rule : rules())
    if (rule.parent == parent && rule.tag == tag) return &rule;
  return nullptr;
}

std::vector<std::string> words_in(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

/// Reason why the words are not `count` finite numbers; empty if they are.
std::string number_defect(const std::vector<std::string>& words, int count) {
  for (const std::string& word : words) {
    const char* const begin = word.data() + (word.size() > 1 && word[0] == '+');
    const char* const end = word.data() + word.size();
    double value = 0;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (stop != end || error == std::errc::invalid_argument)
      return fmt::format("'{:.40}' is not a number", word);
    if (error != std::errc{} || !std::isfinite(value))
      return fmt::format("'{:.40}' is not a finite number in range", word);
  }
  if (static_cast<int>(words.size()) == count) return {};
  return fmt::format("has {} numbers, expected {}", words.size(), count);
}

bool may_be_in_name(char c) {
  return static_cast<unsigned char>(c) >= 0x20 && c != '&' && c != ',' && c != '"';
}

/// Checks the elements of a robot, and removes those that are not read.
class ElementCheck {
 public:
  ElementCheck(pugi::xml_node robot, UrdfReport& report)
      : report_(report), has_links_(robot.child("link")) {}

  /// Checks the elements in `parent` up to an unevaluated xacro element.
  void check(pugi::xml_node parent) {
    for (pugi::xml_node element = parent.first_child(); element && !unevaluated_;) {
      const pugi::xml_node next = element.next_sibling();
      if (const ElementRule* rule = find_rule(parent.name(), element.name())) {
        check_known(element, *rule);
        check(element);
      } else {
        if (element.type() == pugi::node_element) check_unknown(element);
        parent.remove_child(element);
      }
      element = next;
    }
  }

  void check_name(pugi::xml_node element) {
    const pugi::xml_attribute name = element.attribute("name");
    const std::string_view value = name.value();
    if (name && value.empty())
      error(element, "name is empty");
    else if (!std::all_of(value.begin(), value.end(), may_be_in_name))
      error(element,
            "a name may not hold control characters, commas, double quotes or XML entities");
  }

  bool unevaluated() const { return unevaluated_; }
  /// Elements and attributes that are not read.
  const std::set<std::string>& ignored() const { return ignored_; }

 private:
  void check_known(pugi::xml_node element, const ElementRule& rule) {
    check_name(element);
    for (pugi::xml_attribute attribute = element.first_attribute(); attribute && !unevaluated_;) {
      const pugi::xml_attribute next = attribute.next_attribute();
      check_attribute(element, attribute, rule);
      attribute = next;
    }
    if (rule.parent != "robot" && element.parent().child(element.name()) != element)
      error(element, fmt::format("a second <{}> in <{}>", rule.tag, rule.parent));
  }

  void check_attribute(pugi::xml_node element, pugi::xml_attribute attribute,
                       const ElementRule& rule) {
    const std::string_view value = attribute.value();
    if (value.find("${") != value.npos || value.find("$(") != value.npos)
      return report_unevaluated(element);
    const auto known =
        std::find_if(rule.attributes.begin(), rule.attributes.end(),
                     [&](const AttributeRule& a) { return a.name == attribute.name(); });
    if (known == rule.attributes.end()) {
      check_unknown_attribute(element, attribute.name(), rule);
      element.remove_attribute(attribute);
    } else if (known->numbers > 0) {
      const std::vector<std::string> words = words_in(attribute.value());
      if (const std::string defect = number_defect(words, known->numbers); !defect.empty())
        error(element, fmt::format("<{}> {}: {}", element.name(), attribute.name(), defect));
      // The only white space between numbers that urdfdom accepts is one blank.
      attribute.set_value(fmt::format("{}", fmt::join(words, " ")).c_str());
    }
  }

  void check_unknown_attribute(pugi::xml_node element, const std::string& attribute,
                               const ElementRule& rule) {
    const std::string tag = element.name();
    const std::string unknown = fmt::format("<{}> has an attribute {}", tag, attribute);
    std::vector<std::string> known;
    for (const AttributeRule& a : rule.attributes) known.emplace_back(a.name);
    if (tag == "origin")
      error(element, unknown + ", which URDF 1.0 does not have", "write xyz (m) and rpy (rad)");
    else if (!similar_names(attribute, known).empty())
      report_.warning(report_.around(element), unknown + ", which is ignored",
                      name_hint(attribute, known, "attributes"));
    else if (rule.parent != "robot")
      ignored_.insert(tag + "/" + attribute);
  }

  void check_unknown(pugi::xml_node element) {
    const std::string tag = element.name(), parent = element.parent().name();
    if (tag.starts_with("xacro:")) return check_xacro(element);
    if (parent != "robot" && (tag == "link" || tag == "joint"))
      return error(element, fmt::format("<{}> stands inside <{}>", tag, parent),
                   "links and joints stand directly in <robot>");
    std::vector<std::string> readable;
    for (const ElementRule& rule : rules())
      if (rule.parent == parent) readable.emplace_back(rule.tag);
    if (!similar_names(tag, readable).empty())
      report_.warning(report_.around(element),
                      fmt::format("<{}> is not a URDF element and is ignored", tag),
                      name_hint(tag, readable, "elements"));
    ignored_.insert("<" + tag + ">");
  }

  /// A xacro element in a link or joint, or in a file without links, would become content. Others
  /// are merely left over.
  void check_xacro(pugi::xml_node element) {
    if (!has_links_ || std::string_view(element.parent().name()) != "robot")
      return report_unevaluated(element);
    report_.warning({element},
                    fmt::format("<{}> is left over from xacro and is ignored, with what is in it",
                                element.name()));
    ignored_.insert(fmt::format("<{}>", element.name()));
  }

  void report_unevaluated(pugi::xml_node element) {
    report_.error({element}, "this is a xacro file that has not been evaluated",
                  "run `xacro FILE > robot.urdf` first and give the result");
    unevaluated_ = true;
  }

  void error(pugi::xml_node element, const std::string& message, const std::string& hint = {}) {
    report_.error(report_.around(element), message, hint);
  }

  UrdfReport& report_;
  bool has_links_;
  bool unevaluated_ = false;
  std::set<std::string> ignored_;
};

}  // namespace

bool check_urdf_elements(pugi::xml_node robot, UrdfReport& report) {
  if (std::string_view(robot.name()) != "robot") {
    report.error({robot}, fmt::format("the root element is <{}>, not <robot>", robot.name()),
                 "a URDF file is expected");
    return false;
  }
  ElementCheck elements(robot, report);
  elements.check(robot);
  if (elements.unevaluated()) return false;
  if (!robot.attribute("name")) report.error({robot}, "<robot> has no name");
  if (robot.attribute("name") && !*robot.attribute("name").value())
    report.warning({robot}, "<robot>: its name is empty");
  else
    elements.check_name(robot);
  const std::set<std::string>& ignored = elements.ignored();
  if (!ignored.empty()) report.note("not read: " + listed({ignored.begin(), ignored.end()}, 12));
  const auto links = robot.children("link");
  const auto count = std::distance(links.begin(), links.end());
  if (count > 0 && count <= kMaxUrdfLinks) return true;
  report.error({robot}, count == 0 ? "the file has no links"
                                   : fmt::format("the file has {} links, more than {}", count,
                                                 kMaxUrdfLinks));
  return false;
}

void check_urdf_topology(pugi::xml_node robot, const UrdfOptions& options, UrdfReport& report) {
  Topology(robot, options, report).check();
}

}  // namespace conddp
