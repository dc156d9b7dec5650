#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "commands/commands.hpp"
#include "problem_file/first_problem/first_problem.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct InitArguments {
  std::string file, gait, frame, output;
  bool stand = false, force = false;
};

FirstMotion motion_of(const InitArguments& arguments) {
  using Kind = FirstMotion::Kind;
  if (!arguments.gait.empty()) return {.kind = Kind::gait, .gait = arguments.gait};
  if (!arguments.frame.empty()) return {.kind = Kind::reach, .frame = arguments.frame};
  return {.kind = arguments.stand ? Kind::stand : Kind::by_kind};
}

int init(const InitArguments& arguments) {
  const bool to_stdout = arguments.output == "-";
  std::filesystem::path output = arguments.output;
  if (output.empty())
    output = std::filesystem::path(arguments.file).filename().replace_extension(".yaml");
  if (!to_stdout && !arguments.force && std::filesystem::exists(output)) {
    print_error(fmt::format("'{}' exists", output.string()),
                "--force replaces it, -o writes to another file");
    return kExitBadInput;
  }
  Diagnostics diagnostics;
  const std::filesystem::path folder = to_stdout ? "." : output.parent_path() / ".";
  const auto text = first_problem(arguments.file, motion_of(arguments), folder, diagnostics);
  print_messages(diagnostics, text ? Verbosity::kQuiet : Verbosity::kNormal);
  if (!text) return kExitBadInput;
  if (to_stdout) {
    print_result(*text);
    return kExitConverged;
  }
  AtomicFiles files;
  files.add(output, *text);
  files.commit();
  print_result(fmt::format("{}\n", output.string()));
  return kExitConverged;
}

}  // namespace

Command init_command() {
  const auto a = std::make_shared<InitArguments>();
  return {.name = "conddp init",
          .description = "Write a first problem file for a robot",
          .details =
              "The file solves as it is, and has comments. Robots with feet stand or "
              "walk, arms reach, bodies with rotors hover. Contacts are the lowest tips of limbs. "
              "The posture is that of an SRDF beside the URDF, or follows from joint limits and "
              "inverse kinematics. Weights are in proportion to mass and torque limits.",
          .arguments = {{.names = {"FILE"},
                         .value = "FILE.urdf",
                         .description = "Robot",
                         .required = true,
                         .target = &a->file},
                        {.names = {"--gait"},
                         .value = "GAIT",
                         .description = "Walk on the feet",
                         .choices = {"walk", "trot", "pace", "bound", "jump"},
                         .target = &a->gait},
                        {.names = {"--reach"},
                         .value = "FRAME",
                         .description = "Move a frame to a place within its reach",
                         .excludes = "--gait",
                         .target = &a->frame},
                        flag({"--stand"}, a->stand, "Stand still", "--gait"),
                        {.names = {"-o", "--output"},
                         .value = "FILE.yaml",
                         .description = "The file; - prints it (default: named after the robot, in "
                                        "the current folder)",
                         .target = &a->output},
                        flag({"--force"}, a->force, "Replace an existing file")},
          .run = [a] { return init(*a); }};
}

}  // namespace conddp
