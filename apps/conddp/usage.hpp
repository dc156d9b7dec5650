#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace conddp {

/// What to print about a wrong command line, with suggestions for misspelt subcommands and flags.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv);

}  // namespace conddp
