#include <exception>
#include <filesystem>
#include <new>
#include <string>

#include <fmt/format.h>

#include "argument_checks.hpp"
#include "base/atomic_file.hpp"
#include "base/wrap_text.hpp"
#include "commands.hpp"
#include "conddp_version.hpp"
#include "exit_codes.hpp"
#include "help_text.hpp"
#include "messages.hpp"
#include "streams.hpp"
#include "terminal.hpp"
#include "usage.hpp"

namespace {

using namespace conddp;

std::string version_text() {
  const BuildInfo& info = build_info();
  std::string text = fmt::format("conddp {} (revision {}{})\n{}, {}, {}\n", info.version,
                                 info.revision, info.dirty ? ", modified" : "", info.compiler,
                                 info.build_type, info.instruction_set);
  for (const LibraryVersion& library : info.libraries)
    text += fmt::format("{} {}\n", library.name, library.version);
  return text;
}

void add_commands(CLI::App& app, Command& chosen) {
  add_solve_command(app, chosen);
  add_check_command(app, chosen);
  add_verify_command(app, chosen);
  add_contacts_command(app, chosen);
  add_bench_command(app, chosen);
  add_compare_command(app, chosen);
  add_regress_command(app, chosen);
  add_inspect_command(app, chosen);
  add_report_command(app, chosen);
  add_list_command(app, chosen);
  add_schema_command(app, chosen);
  add_completion_command(app, chosen);
  add_man_command(app, chosen);
  add_help_command(app, chosen);
}

/// `--diagnostics` may stand before or behind the subcommand. Its value is read apart from the
/// parser, because errors of the command line have that form too.
constexpr const char* kDiagnostics = "diagnostics";

void add_diagnostics_option(CLI::App& app) {
  app.add_option(std::string("--") + kDiagnostics,
                 "Messages on stderr as text or as JSON, an object a line")
      ->type_name("FORMAT")
      ->default_str("text")
      ->check(CLI::IsMember({"text", "json"}));
}

/// No path is an empty text, such as what the shell makes of a variable that is not set.
void check_paths(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    const OptionDoc doc = describe(*option);
    if (doc.folder || !doc.suffixes.empty()) option->check(not_empty());
  }
}

void report_usage(const CLI::App& app, const CLI::ParseError& error, const CommandWords& words) {
  Diagnostics diagnostics;
  diagnostics.add(usage_error(app, error, words));
  print_messages(diagnostics, Verbosity::kQuiet);
  if (message_format() == MessageFormat::kJson) return;
  const std::string advice =
      words.command == &app
          ? "'conddp --help' lists the subcommands."
          : fmt::format("'conddp {} --help' lists what it takes.", words.command->get_name());
  print_message(wrap_text(advice, terminal_of(2).message_width(), 0, 0));
}

int run(int argc, char** argv) {
  CLI::App app{"Batch trajectory optimisation of robots under constraints", "conddp"};
  app.set_help_flag("-h,--help", "Explain the command and its options");
  Command chosen;
  add_commands(app, chosen);
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text(), "Print the version and how it was built");
  add_diagnostics_option(app);
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    add_diagnostics_option(*command);
    check_paths(*command);
  }

  const CommandWords words = read_words(app, {argv + std::min(argc, 1), argv + argc});
  if (words.value_of(kDiagnostics) == "json") set_message_format(MessageFormat::kJson);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    print_result(help_text(describe(*words.command), terminal_of(1).width));
    return kExitConverged;
  } catch (const CLI::CallForVersion&) {
    print_result(version_text());
    return kExitConverged;
  } catch (const CLI::ParseError& error) {
    report_usage(app, error, words);
    return kExitBadInput;
  }
  return chosen();
}

int run_and_report(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const OutputError& error) {
    print_error(error.what());
    return kExitBadInput;
  } catch (const std::filesystem::filesystem_error& error) {
    // What the user's files and folders are like: the current one is gone, links go in a circle.
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
