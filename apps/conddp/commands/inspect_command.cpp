#include "commands/commands.hpp"
#include "summary/summary.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct InspectArguments {
  std::string file;
  std::string base = "fixed";
  bool json = false;
};

int inspect(const InspectArguments& arguments) {
  UrdfOptions options;
  options.base = arguments.base == "floating" ? UrdfOptions::Base::floating
                 : arguments.base == "planar" ? UrdfOptions::Base::planar
                                              : UrdfOptions::Base::fixed;
  const UrdfResult result = load_urdf(arguments.file, options);
  Diagnostics diagnostics;
  for (const UrdfProblem& problem : result.problems)
    diagnostics.add({.file = arguments.file,
                     .line = problem.line,
                     .column = problem.column,
                     .severity = problem.warning ? Severity::kWarning : Severity::kError,
                     .message = problem.message,
                     .hint = problem.hint});
  print_messages(diagnostics, Verbosity::kNormal);
  if (!result.model) return kExitBadInput;
  print_result(arguments.json ? json_text(robot_json(result)) : robot_text(result));
  return kExitConverged;
}

}  // namespace

Command inspect_command() {
  const auto a = std::make_shared<InspectArguments>();
  return {.name = "conddp inspect",
          .description = "Show what conddp sees in a URDF file",
          .details =
              "Tree, joints with their limits, links with their masses, frames, and what conddp "
              "ignores.",
          .arguments = {{.names = {"FILE"},
                         .value = "FILE.urdf",
                         .description = "Robot",
                         .required = true,
                         .target = &a->file},
                        {.names = {"--base"},
                         .value = "BASE",
                         .description = "Joint between the root link and the world",
                         .choices = {"fixed", "floating", "planar"},
                         .fallback = a->base,
                         .target = &a->base},
                        flag({"--json"}, a->json, "Print JSON (conddp schema inspect)")},
          .run = [a] { return inspect(*a); }};
}

}  // namespace conddp
