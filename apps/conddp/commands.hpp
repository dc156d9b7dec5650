#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace conddp {

/// A subcommand that was chosen: runs it and returns the exit code.
using Command = std::function<int()>;

/// Each adds its subcommand to the parser; when it is chosen, `chosen` is set.
void add_solve_command(CLI::App& app, Command& chosen);
void add_check_command(CLI::App& app, Command& chosen);
void add_inspect_command(CLI::App& app, Command& chosen);

}  // namespace conddp
