#include "robot/urdf/urdf.hpp"

#include <mutex>
#include <sstream>

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <urdf_parser/urdf_parser.h>

#include "base/files/text_file.hpp"
#include "base/text/spelling.hpp"
#include "base/text/utf8.hpp"
#include "robot/urdf/load_xml.hpp"
#include "robot/urdf/model_builder.hpp"
#include "robot/urdf/regularity.hpp"
#include "robot/urdf/urdf_document.hpp"
#include "robot/urdf/urdf_validation.hpp"

namespace conddp {
namespace {

constexpr std::size_t kMaxUrdfBytes = std::size_t{16} << 20;

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
  ParserMessage problem;
  const auto add_problem = [&](const UrdfPlace& place) {
    if (problem.error)
      report.error(place, "urdfdom: " + problem.text);
    else if (!problem.text.empty())
      report.warning(place, "urdfdom: " + problem.text);
    problem = {};
  };
  for (const ParserMessage& message : messages) {
    if (message.text.find("xml is not initialized correctly") != std::string::npos) continue;
    problem.text += (problem.text.empty() ? "" : "; ") + message.text;
    problem.error |= message.error;
    for (const std::string& name : names_in_brackets(message.text))
      for (const UrdfPlace& place : {report.joint(name), report.link(name)})
        if (place.node) add_problem(place);
  }
  add_problem({});
}

/// Reports joints that keep the inertia matrix from being positive definite, with remedies.
class RegularityReport {
 public:
  RegularityReport(const RobotModel& model, const std::string& prefix, UrdfReport& report)
      : model_(model), prefix_(prefix), report_(report) {}

  void check() {
    if (const std::vector<int> bodies = bodies_with_negative_inertia(model_); !bodies.empty()) {
      if (const Joints joints = joints_with_negative_inertia(model_); !joints.empty())
        return report_.error(
            place(joints.front()),
            fmt::format("the links that it moves ({} and all links further out) have a negative "
                        "inertia along it in some configurations, so the robot's inertia matrix "
                        "is not positive definite{}",
                        links(joints), others(joints)),
            "correct the inertias that the warnings name" + ways_out(joints));
      report_.warning(
          {}, fmt::format("the inertias that joints move rigidly ({}) are not positive "
                          "semidefinite; the robot's inertia matrix is positive definite in {} "
                          "configurations within the limits, but may not be in others",
                          listed(names(bodies)), kRegularitySamples));
    }
    if (const Joints joints = joints_without_inertia(model_); !joints.empty())
      return report_.error(
          place(joints.front()),
          fmt::format("no link that it moves ({}) has inertia along it, so the robot's inertia "
                      "matrix is singular{}",
                      links(joints), others(joints)),
          fmt::format("give the {} mass and inertia{}",
                      place(joints.front()).node ? "links" : "root link", ways_out(joints)));
    if (const Joints joints = joints_without_inertia_at_zero(model_); !joints.empty())
      report_.warning(
          place(joints.front()),
          fmt::format("at the zero configuration no link that it moves ({}) has inertia along "
                      "it{}; the robot's inertia matrix is singular there, and solves that come "
                      "near it fail",
                      links(joints), others(joints)),
          "give the links mass and inertia" + ways_out(joints));
  }

 private:
  using Joints = std::vector<int>;

  std::string name(int joint) const { return model_.joints[joint].name.substr(prefix_.size()); }

  UrdfPlace place(int joint) const { return report_.joint(name(joint)); }

  std::vector<std::string> names(const Joints& joints) const {
    std::vector<std::string> found;
    for (const int joint : joints) found.push_back(name(joint));
    return found;
  }

  /// Links that move rigidly with the first joint.
  std::string links(const Joints& joints) const {
    std::vector<std::string> found;
    for (const Frame& frame : model_.frames)
      if (frame.joint == joints.front() && frame.kind == FrameKind::link)
        found.push_back(frame.name.substr(prefix_.size()));
    return listed(found);
  }

  /// Remedies for joints of the file that can be locked, as problem-file keys ready to copy.
  std::string ways_out(const Joints& joints) const {
    std::vector<std::string> locked;
    std::string rotors;
    for (const int joint : joints) {
      if (!place(joint).node || model_.joints[joint].type == JointType::floating) continue;
      locked.push_back(fmt::format("{}: {}", name(joint), zero_position(model_.joints[joint])));
      if (rotors.empty()) rotors = name(joint) + ": 1e-4";
    }
    if (locked.empty()) return "";
    return fmt::format(
        ", lock joints that you do not need ('locked_joints: {{{}}}'), or add the inertia of the "
        "motors' rotors ('rotor_inertia: {{{}{}}}')",
        fmt::join(locked, ", "), rotors, joints.size() > 1 ? ", ..." : "");
  }

  std::string others(const Joints& joints) const {
    if (joints.size() == 1) return "";
    return "; the same holds for " + listed(names({joints.begin() + 1, joints.end()}));
  }

  const RobotModel& model_;
  const std::string& prefix_;
  UrdfReport& report_;
};

/// Parsed and checked tree; it must not be used if the report has errors. Patterns in the options
/// are replaced by joint names.
urdf::ModelInterfaceSharedPtr checked_tree(pugi::xml_node robot, UrdfOptions& options,
                                           UrdfReport& report) {
  if (!check_urdf_elements(robot, report)) return nullptr;
  check_urdf_topology(robot, options, report);
  if (report.has_errors()) return nullptr;

  std::ostringstream xml;
  robot.print(xml, "", pugi::format_raw);
  std::vector<ParserMessage> messages;
  urdf::ModelInterfaceSharedPtr tree = parse_tree(xml.str(), messages);
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

/// Result with an error, behind `before` in the text.
UrdfResult failure(std::string message, std::optional<std::string_view> before = {},
                   std::string hint = {}) {
  const TextPlace place = before ? place_after(*before) : TextPlace{0, 0};
  UrdfResult result;
  result.problems.push_back({.message = std::move(message),
                             .line = place.line,
                             .column = place.column,
                             .hint = std::move(hint)});
  return result;
}

}  // namespace

UrdfResult parse_urdf(std::string_view xml, const std::string& file_name,
                      const UrdfOptions& given) {
  if (xml.find_first_not_of(" \t\r\n") == xml.npos) return failure("'" + file_name + "' is empty");
  if (xml.size() > kMaxUrdfBytes)
    return failure(fmt::format("'{}' is larger than {} MiB", file_name, kMaxUrdfBytes >> 20));
  if (const std::size_t bad = find_bad_character(xml); bad != xml.npos)
    return failure(describe_bad_character(xml, bad), xml.substr(0, bad),
                   static_cast<unsigned char>(xml[bad]) < 0x80
                       ? ""
                       : "convert it, e.g. with iconv -f latin1 -t utf-8");
  pugi::xml_document document;
  if (const auto defect = load_xml(xml, document))
    return failure("not well-formed XML: " + defect->message, xml.substr(0, defect->offset));

  UrdfReport report(document.document_element());
  UrdfOptions options = given;
  std::optional<RobotModel> model;
  const auto tree = checked_tree(document.document_element(), options, report);
  if (!report.has_errors())
    model = build_model(
        *tree, options.enforce_mimic ? with_locked_followers(*tree, options) : options, report);
  if (!report.has_errors()) RegularityReport(*model, options.prefix, report).check();
  UrdfResult result = report.take(xml);
  if (!report.has_errors()) result.model = std::move(model);
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
