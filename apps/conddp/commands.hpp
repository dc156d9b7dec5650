#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace conddp {

/// A subcommand that was chosen: runs it and returns the exit code.
using Command = std::function<int()>;

/// Each adds its subcommand to the parser; when it is chosen, `chosen` is set.
///
/// Help, manual pages and completion read everything from the parser (command_doc.hpp): give every
/// value a type name ("FOLDER" for a folder, "FILE.yaml" for files by their suffix) and, where it
/// is one of several words, the check CLI::IsMember.
void add_solve_command(CLI::App& app, Command& chosen);
void add_check_command(CLI::App& app, Command& chosen);
void add_verify_command(CLI::App& app, Command& chosen);
void add_contacts_command(CLI::App& app, Command& chosen);
void add_bench_command(CLI::App& app, Command& chosen);
void add_compare_command(CLI::App& app, Command& chosen);
void add_regress_command(CLI::App& app, Command& chosen);
void add_inspect_command(CLI::App& app, Command& chosen);
void add_report_command(CLI::App& app, Command& chosen);
void add_list_command(CLI::App& app, Command& chosen);
void add_schema_command(CLI::App& app, Command& chosen);
void add_completion_command(CLI::App& app, Command& chosen);
void add_man_command(CLI::App& app, Command& chosen);
void add_help_command(CLI::App& app, Command& chosen);

}  // namespace conddp
