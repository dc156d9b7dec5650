#include "commands.hpp"
#include "exit_codes.hpp"
#include "messages.hpp"
#include "robot_report.hpp"
#include "streams.hpp"

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

void add_inspect_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("inspect", "Show what conddp sees in a URDF file");
  command->footer(
      "Tree, joints with their limits, links with their masses, frames, and what conddp ignores.");
  const auto a = std::make_shared<InspectArguments>();
  command->add_option("FILE", a->file, "Robot")->required()->type_name("FILE.urdf");
  command->add_option("--base", a->base, "How the root link meets the world")
      ->type_name("BASE")
      ->check(CLI::IsMember({"fixed", "floating", "planar"}))
      ->capture_default_str();
  command->add_flag("--json", a->json, "Print JSON (conddp schema inspect)");
  command->callback([a, &chosen] { chosen = [a] { return inspect(*a); }; });
}

}  // namespace conddp
