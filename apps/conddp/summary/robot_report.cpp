#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "base/text/text_layout.hpp"
#include "summary/summary.hpp"

namespace conddp {
namespace {

std::string limit(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-";
}

bool turns(const Joint& joint) { return joint.type == JointType::revolute; }

std::string_view position_unit(const Joint& joint) {
  return joint.type == JointType::floating ? "" : turns(joint) ? "rad" : "m";
}

std::string_view velocity_unit(const Joint& joint) {
  return joint.type == JointType::floating ? "" : turns(joint) ? "rad/s" : "m/s";
}

std::string_view effort_unit(const Joint& joint) {
  return joint.type == JointType::floating ? "" : turns(joint) ? "Nm" : "N";
}

std::string_view damping_unit(const Joint& joint) {
  return joint.type == JointType::floating ? "" : turns(joint) ? "Nm s/rad" : "N s/m";
}

std::string_view type_name(const Joint& joint) {
  switch (joint.type) {
    case JointType::revolute:
      return std::isfinite(joint.lower) || std::isfinite(joint.upper) ? "revolute" : "continuous";
    case JointType::prismatic:
      return "prismatic";
    case JointType::parameter:
      return "parameter";
    case JointType::floating:
      break;
  }
  return "floating";
}

std::string joint_name(const RobotModel& model, int joint) {
  return joint < 0 ? "the world" : model.joints[joint].name;
}

/// Names of the links that move rigidly with a joint (−1: the world).
std::string links_of(const RobotModel& model, int joint) {
  std::string names;
  for (const Frame& frame : model.frames)
    if (frame.kind == FrameKind::link && frame.joint == joint)
      names += (names.empty() ? "" : ", ") + frame.name;
  return names;
}

struct Masses {
  double all = 0;     ///< of all links, kg
  double moving = 0;  ///< without links fixed to the world, kg
};

Masses masses_of(const RobotModel& model) {
  Masses masses{.moving = model.total_mass()};
  for (const Frame& frame : model.frames) masses.all += frame.mass;
  return masses;
}

std::string tree_text(const RobotModel& model, int parent, const std::string& margin) {
  std::vector<int> children;
  for (int i = 0; i < model.joint_count(); ++i)
    if (model.joints[i].parent == parent) children.push_back(i);
  std::string text;
  for (const int child : children) {
    const bool last = child == children.back();
    const Joint& joint = model.joints[child];
    text += fmt::format("{}{}{} ({}): {}\n", margin, last ? "└─ " : "├─ ", joint.name,
                        type_name(joint), links_of(model, child));
    text += tree_text(model, child, margin + (last ? "   " : "│  "));
  }
  return text;
}

/// Aligned rows of cells: the first column and units left-aligned, numbers right-aligned.
std::string table(const std::vector<std::vector<std::string>>& rows, const std::string& alignment) {
  std::vector<int> widths(alignment.size(), 0);
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i)
      widths[i] = std::max(widths[i], shown_width(row[i]));
  std::string text;
  for (const auto& row : rows) {
    std::string line = " ";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - shown_width(row[i]), ' ');
      line += " " + (alignment[i] == 'r' ? space + row[i] : row[i] + space);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string joints_text(const RobotModel& model) {
  std::vector<std::vector<std::string>> rows = {{"name", "type", "lower", "upper", "", "velocity",
                                                 "", "effort", "", "moves", "", "damping", ""}};
  for (const Joint& joint : model.joints) {
    const auto unit = [](std::string_view name) { return std::string(name); };
    rows.push_back({joint.name, unit(type_name(joint)), limit(joint.lower), limit(joint.upper),
                    unit(position_unit(joint)), limit(joint.max_velocity),
                    unit(velocity_unit(joint)), limit(joint.max_effort), unit(effort_unit(joint)),
                    fmt::format("{:.4g}", joint.inertia.mass), "kg",
                    fmt::format("{:.4g}", joint.damping), unit(damping_unit(joint))});
  }
  return "\njoints (in the order of the state)\n" + table(rows, "llrrlrlrlrlrl");
}

std::string links_text(const RobotModel& model) {
  std::vector<std::vector<std::string>> rows;
  for (const Frame& frame : model.frames)
    if (frame.kind == FrameKind::link)
      rows.push_back({frame.name, fmt::format("{:.6g}", frame.mass), "kg",
                      "on " + joint_name(model, frame.joint)});
  const Masses masses = masses_of(model);
  rows.push_back({"total", fmt::format("{:.6g}", masses.all), "kg", ""});
  return "\nlinks\n" + table(rows, "lrll");
}

std::string frames_text(const RobotModel& model) {
  std::map<int, std::string> by_body;
  for (const Frame& frame : model.frames) {
    std::string& list = by_body[frame.joint];
    list += (list.empty() ? "" : ", ") + frame.name;
    if (frame.kind == FrameKind::joint) list += " (joint)";
  }
  std::string text = "\nframes\n";
  for (const auto& [joint, list] : by_body)
    text += fmt::format("  on {}: {}\n", joint_name(model, joint), list);
  return text;
}

OrderedJson number(double value) {
  return std::isfinite(value) ? OrderedJson(value) : OrderedJson(nullptr);
}

}  // namespace

std::string robot_text(const UrdfResult& robot) {
  const RobotModel& model = *robot.model;
  const std::string fixed = links_of(model, -1);
  std::string text = fmt::format(
      "{}: {} degrees of freedom ({} numbers in q), {:.6g} kg move\n\nworld{}\n", model.name,
      model.nv, model.nq, masses_of(model).moving, fixed.empty() ? "" : ": " + fixed);
  text += tree_text(model, -1, "") + joints_text(model) + links_text(model) + frames_text(model);
  if (!robot.notes.empty()) text += "\nconddp ignores\n";
  for (const std::string& note : robot.notes) text += "  " + note + "\n";
  return text;
}

OrderedJson robot_json(const UrdfResult& robot) {
  const RobotModel& model = *robot.model;
  const auto on = [&](int joint) {
    return joint < 0 ? OrderedJson(nullptr) : OrderedJson(model.joints[joint].name);
  };
  OrderedJson joints = OrderedJson::array(), links = OrderedJson::array(),
              frames = OrderedJson::array();
  for (const Joint& joint : model.joints)
    joints.push_back({{"name", joint.name},
                      {"type", type_name(joint)},
                      {"parent", on(joint.parent)},
                      {"q", joint.q},
                      {"v", joint.v},
                      {"lower", number(joint.lower)},
                      {"upper", number(joint.upper)},
                      {"max_velocity", number(joint.max_velocity)},
                      {"max_effort", number(joint.max_effort)},
                      {"damping", joint.damping},
                      {"friction", joint.friction},
                      {"mass_kg", joint.inertia.mass}});
  for (const Frame& frame : model.frames) {
    if (frame.kind == FrameKind::link)
      links.push_back({{"name", frame.name}, {"joint", on(frame.joint)}, {"mass_kg", frame.mass}});
    frames.push_back({{"name", frame.name},
                      {"kind", frame.kind == FrameKind::link ? "link" : "joint"},
                      {"joint", on(frame.joint)}});
  }
  const Masses masses = masses_of(model);
  return {{"format", "conddp.inspect/1"},
          {"name", model.name},
          {"nq", model.nq},
          {"nv", model.nv},
          {"mass_kg", {{"total", masses.all}, {"moving", masses.moving}}},
          {"joints", std::move(joints)},
          {"links", std::move(links)},
          {"frames", std::move(frames)},
          {"ignored", robot.notes}};
}

}  // namespace conddp
