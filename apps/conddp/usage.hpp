#pragma once

#include "base/diagnostic.hpp"
#include "command_words.hpp"

namespace conddp {

/// What is wrong with a command line that the parser refused, with suggestions for misspelt
/// subcommands, flags and values.
Diagnostic usage_error(const CLI::App& app, const CLI::ParseError& error,
                       const CommandWords& words);

}  // namespace conddp
