#include "robot/urdf.hpp"

#include <algorithm>
#include <mutex>

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include "robot/model_builder.hpp"
#include "robot/regularity.hpp"
#include "robot/text_file.hpp"
#include "robot/urdf_guard.hpp"
#include "robot/urdf_topology.hpp"
#include "robot/urdf_validation.hpp"

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

/// urdfdom reports through one handler of the whole process: one parse at a time.
urdf::ModelInterfaceSharedPtr parse_tree(const std::string& xml,
                                         std::vector<ParserMessage>& messages) {
  static std::mutex mutex;
  static MessageCollector collector;  // outlives the pointer that console_bridge keeps of it
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

/// urdfdom writes several lines about one defect, the last ones with the joint's or link's name in
/// brackets: they become one problem at that place.
void report_parser_messages(const std::vector<ParserMessage>& messages, UrdfReport& report) {
  std::string text;
  bool error = false;
  const auto flush = [&](const UrdfPlace& place) {
    if (text.empty()) return;
    if (error)
      report.error(place, "urdfdom: " + text);
    else
      report.warning(place, "urdfdom: " + text);
    text.clear();
    error = false;
  };
  for (const ParserMessage& message : messages) {
    if (message.text.find("xml is not initialized correctly") != std::string::npos) continue;
    text += (text.empty() ? "" : "; ") + message.text;
    error |= message.error;
    for (std::size_t open = message.text.find('['); open != std::string::npos;
         open = message.text.find('[', open + 1)) {
      const std::string rest = message.text.substr(open + 1);
      const std::string name = rest.substr(0, rest.find(']'));
      if (report.has("joint", name)) flush(at_joint(name));
      if (report.has("link", name)) flush(at_link(name));
    }
  }
  flush({});
}

void check_regular(const RobotModel& model, const std::string& prefix, UrdfReport& report) {
  for (const int index : joints_without_inertia(model)) {
    const std::string name = model.joints[index].name.substr(prefix.size());
    std::vector<std::string> links;
    for (const Frame& frame : model.frames)
      if (frame.joint == index && frame.kind == FrameKind::link)
        links.push_back(frame.name.substr(prefix.size()));
    const std::string message = "nothing that it moves (" + listed(links) +
                                ") has inertia along it, so the robot's inertia matrix is singular";
    const std::string hint =
        "give the links mass and inertia, lock the joint, or give it a rotor inertia";
    if (report.has("joint", name))
      report.error(at_joint(name), message, hint);
    else
      report.error({"joint", name}, message, "give the root link mass and inertia");
  }
}

void parse(std::string_view xml, const UrdfOptions& options, UrdfResult& result) {
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
  if (!check_urdf_elements(outline, report)) return;
  check_urdf_topology(outline, report);
  if (report.has_errors()) return;

  std::vector<ParserMessage> messages;
  const urdf::ModelInterfaceSharedPtr tree = parse_tree(relevant_urdf(outline, xml), messages);
  report_parser_messages(messages, report);
  if (report.has_errors()) return;
  if (!tree || !tree->getRoot()) return report.error({}, "urdfdom could not read the file");

  check_urdf_physics(*tree, report);
  check_urdf_options(*tree, options, report);
  if (report.has_errors()) return;
  RobotModel model = build_model(*tree, options, report);
  if (!report.has_errors()) check_regular(model, options.prefix, report);
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
