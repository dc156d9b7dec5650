#include <cmath>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "arguments/problem_arguments.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/json/ordered_json.hpp"
#include "commands/commands.hpp"
#include "problem_file/motion/state_builder.hpp"
#include "problem_file/plant/plant_builder.hpp"
#include "problem_file/read/read_problem.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct ReachArguments : ProblemArguments {
  std::string frame, at, rpy, from;
};

/// A list of a command-line value, with or without its brackets.
std::string list_of(const std::string& value) {
  return value.starts_with('[') ? value : "[" + value + "]";
}

/// The setting of an initial state with the arguments' frame.
std::string setting_of(const ReachArguments& arguments) {
  std::string placement = "position: " + list_of(arguments.at);
  if (!arguments.rpy.empty()) placement += ", rpy: " + list_of(arguments.rpy);
  const std::string frames =
      fmt::format("{{{}: {{{}}}}}", OrderedJson(arguments.frame).dump(), placement);
  if (arguments.from.empty()) return "initial_state.frames=" + frames;
  return fmt::format("initial_state={{configuration: {}, frames: {}}}",
                     OrderedJson(arguments.from).dump(), frames);
}

/// The problem file, or for a URDF file the smallest problem of its robot.
std::optional<ProblemDocument> document_of(const ReachArguments& arguments, Diagnostics& out) {
  if (!arguments.file.ends_with(".urdf")) return load_problem_of(arguments, out);
  if (!std::filesystem::exists(arguments.file)) {
    out.error({}, fmt::format("'{}' does not exist", arguments.file));
    return std::nullopt;
  }
  return parse_problem(
      fmt::format("conddp: 1\nrobot: {{urdf: {}}}\nphases: [{{knots: 1, dt: 0.1}}]\n"
                  "costs: {{effort: {{residual: control}}}}\n",
                  OrderedJson(arguments.file).dump()),
      "reach.yaml", out);
}

/// Positions of joints, as configurations and states of problem files take them.
std::string joints_text(const Plant& plant, const std::vector<double>& x) {
  const MultibodySystem& system = *plant.multibody();
  constexpr double kNothing = 1e-12;  // rad or m
  std::string text = "joints:\n";
  for (const int joint : movable_joints(system, 0, system.robot().joint_count())) {
    const double q = x[*system.position_index(joint)];
    text += fmt::format("  {}: {:.10g}\n", OrderedJson(system.robot().joints[joint].name).dump(),
                        std::abs(q) < kNothing ? 0 : q);
  }
  return text;
}

int reach(ReachArguments& arguments) {
  Diagnostics diagnostics;
  arguments.settings.push_back(setting_of(arguments));
  const auto spec =
      read_problem(document_of(arguments, diagnostics), settings_of(arguments), diagnostics);
  if (spec && spec->system)
    diagnostics.error({}, "the problem has no robot: its system is given by equations");
  const auto plant = diagnostics.has_errors() ? std::nullopt : build_plant(*spec, diagnostics);
  const auto x =
      plant ? StateBuilder(*plant, diagnostics).build(spec->initial_state) : std::nullopt;
  print_messages(diagnostics, verbosity_of(arguments));
  if (!x) return kExitBadInput;
  print_result(joints_text(*plant, *x));
  return kExitConverged;
}

}  // namespace

Command reach_command() {
  const auto a = std::make_shared<ReachArguments>();
  return {.name = "conddp reach",
          .description = "Find joint positions that put a frame somewhere (inverse kinematics)",
          .details =
              "Joints move within their limits, as little as possible from the initial state "
              "of the problem, or from 0 for a URDF file; bases stay. The loops of a problem "
              "close, and the shapes of its distances keep apart.",
          .arguments = {{.names = {"FILE"},
                         .value = "FILE.urdf.yaml",
                         .description = "Robot, or a problem with robots",
                         .required = true,
                         .target = &a->file},
                        {.names = {"--frame"},
                         .value = "FRAME",
                         .description = "What to put there",
                         .required = true,
                         .target = &a->frame},
                        {.names = {"--at"},
                         .value = "[X,Y,Z]",
                         .description = "Position of its origin in the world, m",
                         .required = true,
                         .target = &a->at},
                        {.names = {"--rpy"},
                         .value = "[R,P,Y]",
                         .description = "Rotation of its axes (roll, pitch, yaw about fixed axes), "
                                        "rad; without it any",
                         .target = &a->rpy},
                        {.names = {"--from"},
                         .value = "NAME",
                         .description = "Configuration to start from instead of the initial state",
                         .target = &a->from},
                        setting_argument(a->settings, "Replace a value of the problem file")},
          .run = [a] { return reach(*a); }};
}

}  // namespace conddp
