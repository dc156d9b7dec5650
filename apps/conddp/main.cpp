#include <algorithm>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "arguments/installed_data.hpp"
#include "arguments/parser.hpp"
#include "arguments/usage.hpp"
#include "base/files/atomic_file.hpp"
#include "base/shared_library.hpp"
#include "base/text/text_layout.hpp"
#include "commands/batch_actions.hpp"
#include "commands/commands.hpp"
#include "conddp_version.hpp"
#include "help/help.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/heap.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace {

using namespace conddp;

std::string version_text() {
  const BuildInfo& info = build_info();
  std::string text = fmt::format("conddp {} (revision {}{})\n{}, {}, {}, {}\n", info.version,
                                 info.revision, info.dirty ? ", modified" : "", info.compiler,
                                 info.build_type, info.instruction_set, installed_package());
  for (const LibraryVersion& library : info.libraries)
    text += fmt::format("{} {}\n", library.name, library.version);
  return text;
}

/// Read separately from the parser, because errors of the command line also have that format. The
/// option may come before or after the subcommand.
constexpr const char* kDiagnostics = "--diagnostics";

/// Adds the options common to the program and all subcommands around its own options.
void add_common_options(Command& command) {
  command.arguments.insert(command.arguments.begin(),
                           {.names = {"-h", "--help"},
                            .description = "Explain the command and its options",
                            .target = EndingFlag::kHelp});
  command.arguments.push_back(
      {.names = {kDiagnostics},
       .value = "FORMAT",
       .description = "Messages on stderr as text or as JSON, an object a line",
       .choices = {"text", "json"},
       .fallback = "text"});
}

/// Subcommands that do not read problem files.
constexpr std::string_view kWithoutProblems[] = {"compare", "inspect", "init",       "list",
                                                 "schema",  "help",    "completion", "man"};

/// Fills `tool`; some subcommands refer to it. `allows_code`: true if --allow-code is given.
void declare(Command& tool, bool& allows_code) {
  tool = {
      .name = "conddp",
      .description =
          "Trajectory optimizer for robots: whole-body optimal control with DDP solvers and Ipopt",
      .arguments = {{.names = {"--version"},
                     .description = "Print the version and how it was built",
                     .target = EndingFlag::kVersion}},
      .commands = {
          solve_command(),   check_command(),          verify_command(),  contacts_command(),
          bench_command(),   batch_command(),          mpc_command(),     margins_command(),
          compare_command(), regress_command(),        inspect_command(), init_command(),
          reach_command(),   report_command(),         serve_command(),   list_command(),
          schema_command(),  completion_command(tool), man_command(tool), help_command(tool)}};
  std::vector<std::string> names;
  for (const Command& command : tool.commands) names.push_back(command.short_name());
  add_common_options(tool);
  for (Command& command : tool.commands) {
    for (Argument& argument : command.arguments)
      if (argument.value == kSubcommandValue) argument.choices = names;
    if (std::ranges::find(kWithoutProblems, command.short_name()) == std::end(kWithoutProblems))
      command.arguments.push_back(
          flag({kAllowCode}, allows_code,
               "Run compiled code that the problem file names, with all your permissions"));
    add_common_options(command);
  }
}

void report_usage(const Command& tool, const CommandWords& words, std::string message) {
  Diagnostics diagnostics;
  diagnostics.add(usage_error(tool, words, std::move(message)));
  print_messages(diagnostics, Verbosity::kQuiet);
  if (message_format() == MessageFormat::kJson) return;
  const std::string advice =
      words.command == &tool ? "'conddp --help' lists the subcommands."
                             : fmt::format("'{} --help' lists what it takes.", words.command->name);
  print_message(wrap_text(advice, terminal_of(2).message_width(), 0, 0));
}

int run(int argc, char** argv) {
  if (argc >= 3 && argv[1] == kBatchWorker) {
    prepare_heap();
    if (argc == 4 && argv[3] == std::string_view(kAllowCode)) allow_code();
    return batch_worker(argv[2]);
  }
  Command tool;
  bool allows_code = false;
  declare(tool, allows_code);
  const CommandWords words = read_words(tool, {argv + std::min(argc, 1), argv + argc});
  if (words.value_of(kDiagnostics) == "json") set_message_format(MessageFormat::kJson);
  ParseEnd end = parse(tool, *words.command, argc, argv);
  switch (end.kind) {
    case ParseEnd::Kind::kHelp:
      print_result(help_text(*words.command, terminal_of(1).width));
      return kExitConverged;
    case ParseEnd::Kind::kVersion:
      print_result(version_text());
      return kExitConverged;
    case ParseEnd::Kind::kError:
      report_usage(tool, words, std::move(end.message));
      return kExitBadInput;
    case ParseEnd::Kind::kCommand:
      break;
  }
  prepare_heap();
  if (allows_code) allow_code();
  return words.command->run();
}

int run_and_report(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const OutputError& error) {
    print_error(error.what());
    return kExitBadInput;
  } catch (const LibraryError& error) {
    print_error(error.what());
    return kExitBadInput;
  } catch (const std::filesystem::filesystem_error& error) {
    // Conditions of the user's file system: the current folder was removed, or links form a cycle.
    const std::string path = error.path1().string();
    print_error(fmt::format("{} cannot be reached: {}",
                            path.empty() ? "the current folder" : "'" + path + "'",
                            error.code().message()));
    return kExitBadInput;
  } catch (const std::bad_alloc&) {
    print_error("there is not enough memory");
    return kExitBadInput;
  } catch (const std::exception& error) {
    print_error(fmt::format("internal error: {}", error.what()),
                fmt::format("this is a defect of conddp; please report it with the command and its "
                            "files (version {}, revision {})",
                            build_info().version, build_info().revision));
  } catch (...) {
    print_error("internal error of unknown kind", "this is a defect of conddp; please report it");
  }
  return kExitDefect;
}

}  // namespace

int main(int argc, char** argv) {
  prepare_streams();
  const int code = run_and_report(argc, argv);
  if (const char* reason = finish_results()) {
    print_error(fmt::format("the results cannot be written to stdout: {}", reason));
    return code == kExitDefect ? code : kExitBadInput;
  }
  return code;
}
