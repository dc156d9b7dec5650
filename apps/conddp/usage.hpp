#pragma once

#include "command_words.hpp"
#include "problem_file/diagnostic.hpp"

namespace conddp {

/// What is wrong with a command line that the parser refused, with suggestions for misspelt
/// subcommands, flags and values.
Diagnostic usage_error(const CLI::App& app, const CLI::ParseError& error,
                       const CommandWords& words);

}  // namespace conddp
