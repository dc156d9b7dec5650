#include <cmath>
#include <map>

#include <fmt/format.h>

#include "commands.hpp"
#include "exit_codes.hpp"
#include "messages.hpp"
#include "robot/urdf.hpp"

namespace conddp {
namespace {

std::string limit(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-";
}

std::string_view unit_of(const Joint& joint, bool force) {
  const bool turns = joint.type == JointType::revolute;
  return force ? (turns ? "Nm" : "N") : (turns ? "rad" : "m");
}

std::string_view type_name(const Joint& joint) {
  switch (joint.type) {
    case JointType::revolute:
      return std::isfinite(joint.lower) || std::isfinite(joint.upper) ? "revolute" : "continuous";
    case JointType::prismatic:
      return "prismatic";
    case JointType::floating:
      break;
  }
  return "floating";
}

/// Names of the links that move rigidly with a joint (−1: the world).
std::string links_of(const RobotModel& model, int joint) {
  std::string names;
  for (const Frame& frame : model.frames)
    if (frame.kind == FrameKind::link && frame.joint == joint)
      names += (names.empty() ? "" : ", ") + frame.name;
  return names;
}

void print_tree(const RobotModel& model, int parent, const std::string& margin) {
  std::vector<int> children;
  for (int i = 0; i < model.joint_count(); ++i)
    if (model.joints[i].parent == parent) children.push_back(i);
  for (const int child : children) {
    const bool last = child == children.back();
    const Joint& joint = model.joints[child];
    fmt::print("{}{}{} ({}): {}\n", margin, last ? "└─ " : "├─ ", joint.name, type_name(joint),
               links_of(model, child));
    print_tree(model, child, margin + (last ? "   " : "│  "));
  }
}

void print_joints(const RobotModel& model) {
  std::size_t width = 5;
  for (const Joint& joint : model.joints) width = std::max(width, joint.name.size());
  fmt::print(
      "\njoints (in the order of the state)\n  {:<{}} {:<10} {:>10} {:>10} {:>4} {:>10} {:>10} "
      "{:>3}"
      " {:>9} {:>9}\n",
      "name", width, "type", "lower", "upper", "", "velocity", "effort", "", "mass [kg]",
      "damping");
  for (const Joint& joint : model.joints)
    fmt::print("  {:<{}} {:<10} {:>10} {:>10} {:>4} {:>10} {:>10} {:>3} {:>9.4g} {:>9.4g}\n",
               joint.name, width, type_name(joint), limit(joint.lower), limit(joint.upper),
               joint.type == JointType::floating ? "" : unit_of(joint, false),
               limit(joint.max_velocity), limit(joint.max_effort),
               joint.type == JointType::floating ? "" : unit_of(joint, true), joint.inertia.mass,
               joint.damping);
}

void print_frames(const RobotModel& model) {
  fmt::print("\nframes\n");
  std::map<int, std::string> by_body;
  for (const Frame& frame : model.frames) {
    std::string& list = by_body[frame.joint];
    list += (list.empty() ? "" : ", ") + frame.name;
    if (frame.kind == FrameKind::joint) list += " (joint)";
  }
  for (const auto& [joint, list] : by_body)
    fmt::print("  on {}: {}\n", joint < 0 ? "the world" : model.joints[joint].name, list);
}

int inspect(const std::string& file, const std::string& base) {
  UrdfOptions options;
  options.base = base == "floating" ? UrdfOptions::Base::floating
                 : base == "planar" ? UrdfOptions::Base::planar
                                    : UrdfOptions::Base::fixed;
  const UrdfResult result = load_urdf(file, options);
  Diagnostics diagnostics;
  for (const UrdfProblem& problem : result.problems)
    diagnostics.add({.file = file,
                     .line = problem.line,
                     .column = problem.column,
                     .severity = problem.warning ? Severity::kWarning : Severity::kError,
                     .message = problem.message,
                     .hint = problem.hint});
  print_messages(diagnostics, Verbosity::kNormal);
  if (!result.model) return kExitBadInput;
  const RobotModel& model = *result.model;
  double moving_mass = 0;
  for (const Joint& joint : model.joints) moving_mass += joint.inertia.mass;
  const std::string fixed = links_of(model, -1);
  fmt::print("{}: {} degrees of freedom ({} numbers in q), {:.6g} kg move\n\nworld{}\n", model.name,
             model.nv, model.nq, moving_mass, fixed.empty() ? "" : ": " + fixed);
  print_tree(model, -1, "");
  print_joints(model);
  print_frames(model);
  if (!result.notes.empty()) fmt::print("\nconddp ignores\n");
  for (const std::string& note : result.notes) fmt::print("  {}\n", note);
  return kExitConverged;
}

}  // namespace

void add_inspect_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("inspect", "Show what conddp sees in a URDF file");
  const auto file = std::make_shared<std::string>();
  const auto base = std::make_shared<std::string>("fixed");
  command->add_option("FILE", *file, "Robot (URDF)")->required();
  command->add_option("--base", *base, "How the root link meets the world")
      ->check(CLI::IsMember({"fixed", "floating", "planar"}))
      ->capture_default_str();
  command->callback(
      [file, base, &chosen] { chosen = [file, base] { return inspect(*file, *base); }; });
}

}  // namespace conddp
