#include "robot/urdf/urdf.hpp"

#include <algorithm>
#include <mutex>

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <urdf_parser/urdf_parser.h>

#include "base/files/text_file.hpp"
#include "robot/urdf/model_builder.hpp"
#include "robot/urdf/regularity.hpp"
#include "robot/urdf/urdf_guard.hpp"
#include "robot/urdf/urdf_topology.hpp"
#include "robot/urdf/urdf_validation.hpp"

namespace conddp {
namespace {

struct ParserMessage {
  std::string text;
  bool error = false;
};

class MessageCollector : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    messages.push_back({text, level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR});
  }
  std::vector<ParserMessage> messages;
};

/// urdfdom reports through one process-wide handler, so only one parse runs at a time.
urdf::ModelInterfaceSharedPtr parse_tree(const std::string& xml,
                                         std::vector<ParserMessage>& messages) {
  static std::mutex mutex;
  static MessageCollector collector;  // outlives console_bridge's pointer to it
  const std::lock_guard lock(mutex);
  console_bridge::OutputHandler* const handler = console_bridge::getOutputHandler();
  const console_bridge::LogLevel level = console_bridge::getLogLevel();
  console_bridge::setLogLevel(console_bridge::CONSOLE_BRIDGE_LOG_WARN);
  console_bridge::useOutputHandler(&collector);
  collector.messages.clear();
  urdf::ModelInterfaceSharedPtr tree;
  try {
    tree = urdf::parseURDF(xml);
  } catch (const std::exception& e) {
    collector.messages.push_back({e.what(), true});
  }
  console_bridge::useOutputHandler(handler);
  console_bridge::setLogLevel(level);
  messages = std::move(collector.messages);
  return tree;
}

/// Messages about one defect, collected until its place in the file is known.
class PendingMessages {
 public:
  explicit PendingMessages(UrdfReport& report) : report_(report) {}

  void add(const ParserMessage& message) {
    text_ += (text_.empty() ? "" : "; ") + message.text;
    error_ |= message.error;
  }
  /// Reports them as one problem.
  void flush(const UrdfPlace& place) {
    if (text_.empty()) return;
    if (error_)
      report_.error(place, "urdfdom: " + text_);
    else
      report_.warning(place, "urdfdom: " + text_);
    text_.clear();
    error_ = false;
  }

 private:
  UrdfReport& report_;
  std::string text_;
  bool error_ = false;
};

std::vector<std::string> names_in_brackets(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t open = text.find('['); open != text.npos; open = text.find('[', open + 1)) {
    const std::string rest = text.substr(open + 1);
    names.push_back(rest.substr(0, rest.find(']')));
  }
  return names;
}

/// urdfdom writes several lines about one defect; the last ones name the joint or link in brackets.
/// These lines become one problem at that joint or link.
void report_parser_messages(const std::vector<ParserMessage>& messages, UrdfReport& report) {
  PendingMessages pending(report);
  for (const ParserMessage& message : messages) {
    if (message.text.find("xml is not initialized correctly") != std::string::npos) continue;
    pending.add(message);
    for (const std::string& name : names_in_brackets(message.text)) {
      if (report.has("joint", name)) pending.flush(at_joint(name));
      if (report.has("link", name)) pending.flush(at_link(name));
    }
  }
  pending.flush({});
}

/// Reports joints that keep the inertia matrix from being positive definite, with remedies.
class RegularityReport {
 public:
  RegularityReport(const RobotModel& model, const std::string& prefix, UrdfReport& report)
      : model_(model), prefix_(prefix), report_(report) {}

  void check() {
    if (const std::vector<int> bodies = bodies_with_negative_inertia(model_); !bodies.empty()) {
      const std::vector<int> joints = joints_with_negative_inertia(model_);
      if (!joints.empty()) return report_negative(joints);
      report_.warning(
          {},
          "the inertias that joints move rigidly (" + listed(names(bodies)) +
              ") are not positive semidefinite; the robot's inertia matrix is positive definite "
              "in " +
              std::to_string(kRegularitySamples) +
              " configurations within the limits, but may not be in others");
    }
    if (const std::vector<int> joints = joints_without_inertia(model_); !joints.empty())
      return report_massless(joints);
    if (const std::vector<int> joints = joints_without_inertia_at_zero(model_); !joints.empty())
      report_.warning(
          place(joints.front()),
          "at the zero configuration no link that it moves (" + links(joints.front()) +
              ") has inertia along it" + others(joints) +
              "; the robot's inertia matrix is singular there, and solves that come near it fail",
          "give the links mass and inertia" + ways_out(joints));
  }

 private:
  std::string name(int joint) const { return model_.joints[joint].name.substr(prefix_.size()); }

  std::vector<std::string> names(const std::vector<int>& joints) const {
    std::vector<std::string> found;
    for (const int joint : joints) found.push_back(name(joint));
    return found;
  }

  std::string links(int joint) const {
    std::vector<std::string> found;
    for (const Frame& frame : model_.frames)
      if (frame.joint == joint && frame.kind == FrameKind::link)
        found.push_back(frame.name.substr(prefix_.size()));
    return listed(found);
  }

  bool can_be_locked(int joint) const {
    return report_.has("joint", name(joint)) && model_.joints[joint].type != JointType::floating;
  }

  /// Remedies for joints of the file that can be locked, as problem-file keys ready to copy.
  std::string ways_out(const std::vector<int>& joints) const {
    std::vector<std::string> locked;
    std::string rotors;
    for (const int joint : joints) {
      if (!can_be_locked(joint)) continue;
      locked.push_back(fmt::format("{}: {}", name(joint), zero_position(model_.joints[joint])));
      if (rotors.empty()) rotors = name(joint) + ": 1e-4";
    }
    if (locked.empty()) return "";
    return fmt::format(
        ", lock joints that you do not need ('locked_joints: {{{}}}'), or add the inertia of the "
        "motors' rotors ('rotor_inertia: {{{}{}}}')",
        fmt::join(locked, ", "), rotors, joints.size() > 1 ? ", ..." : "");
  }

  UrdfPlace place(int joint) const {
    return report_.has("joint", name(joint)) ? at_joint(name(joint))
                                             : UrdfPlace{"joint", name(joint)};
  }

  std::string others(const std::vector<int>& joints) const {
    if (joints.size() == 1) return "";
    return "; the same holds for " + listed(names({joints.begin() + 1, joints.end()}));
  }

  void report_massless(const std::vector<int>& joints) {
    const int first = joints.front();
    const bool root = !report_.has("joint", name(first));
    report_.error(
        place(first),
        "no link that it moves (" + links(first) +
            ") has inertia along it, so the robot's inertia matrix is singular" + others(joints),
        (root ? "give the root link mass and inertia" : "give the links mass and inertia") +
            ways_out(joints));
  }

  void report_negative(const std::vector<int>& joints) {
    report_.error(place(joints.front()),
                  "the links that it moves (" + links(joints.front()) +
                      " and all links further out) have a negative inertia along it in some "
                      "configurations, so the robot's inertia matrix is not positive definite" +
                      others(joints),
                  "correct the inertias that the warnings name" + ways_out(joints));
  }

  const RobotModel& model_;
  const std::string& prefix_;
  UrdfReport& report_;
};

/// Parsed and checked tree; it must not be used if the report has errors. Patterns in the options
/// are replaced by joint names.
urdf::ModelInterfaceSharedPtr checked_tree(const XmlOutline& outline, std::string_view xml,
                                           UrdfOptions& options, UrdfReport& report) {
  if (!check_urdf_elements(outline, report)) return nullptr;
  check_urdf_topology(outline, options, report);
  if (report.has_errors()) return nullptr;

  std::vector<ParserMessage> messages;
  urdf::ModelInterfaceSharedPtr tree = parse_tree(relevant_urdf(outline, xml), messages);
  report_parser_messages(messages, report);
  if (report.has_errors()) return nullptr;
  if (!tree || !tree->getRoot()) {
    report.error({}, "urdfdom could not read the file");
    return nullptr;
  }

  options = resolve_joint_patterns(*tree, std::move(options), report);
  check_urdf_physics(*tree, options, report);
  check_urdf_options(*tree, options, report);
  return tree;
}

/// Options that also lock all followers of locked joints, at the positions these imply. Earlier
/// checks exclude cycles.
UrdfOptions with_locked_followers(const urdf::ModelInterface& tree, UrdfOptions options) {
  for (std::size_t known = 0; known != options.locked_joints.size();) {
    known = options.locked_joints.size();
    for (const auto& [name, joint] : tree.joints_) {
      if (!joint->mimic || options.locked_joints.contains(name)) continue;
      const auto leader = options.locked_joints.find(joint->mimic->joint_name);
      if (leader != options.locked_joints.end())
        options.locked_joints[name] =
            joint->mimic->multiplier * leader->second + joint->mimic->offset;
    }
  }
  return options;
}

void parse(std::string_view xml, UrdfOptions options, UrdfResult& result) {
  const XmlOutline outline = scan_xml(xml);
  UrdfReport report(outline, result);
  if (outline.defect || outline.elements.empty()) {
    const XmlDefect defect =
        outline.defect.value_or(XmlDefect{"the file has no XML element", 1, 1});
    result.problems.push_back({.message = "not well-formed XML: " + defect.message,
                               .line = defect.line,
                               .column = defect.column});
    return;
  }
  const urdf::ModelInterfaceSharedPtr tree = checked_tree(outline, xml, options, report);
  if (report.has_errors()) return;
  RobotModel model = build_model(
      *tree, options.enforce_mimic ? with_locked_followers(*tree, options) : options, report);
  if (!report.has_errors()) RegularityReport(model, options.prefix, report).check();
  if (!report.has_errors()) result.model = std::move(model);
}

UrdfResult failure(std::string message) {
  UrdfResult result;
  result.problems.push_back({.message = std::move(message)});
  return result;
}

}  // namespace

UrdfResult parse_urdf(std::string_view xml, const std::string& file_name,
                      const UrdfOptions& options) {
  UrdfResult result;
  if (auto problem = check_urdf_text(xml, file_name)) {
    result.problems.push_back(std::move(*problem));
    return result;
  }
  parse(xml, options, result);
  std::stable_sort(result.problems.begin(), result.problems.end(),
                   [](const UrdfProblem& a, const UrdfProblem& b) { return a.line < b.line; });
  return result;
}

UrdfResult load_urdf(const std::filesystem::path& file, const UrdfOptions& options) {
  TextFile read = read_text_file(file, kMaxUrdfBytes);
  if (!read.defect.empty()) return failure(std::move(read.defect));
  UrdfResult result = parse_urdf(read.text, file.string(), options);
  result.text = std::move(read.text);
  return result;
}

}  // namespace conddp
