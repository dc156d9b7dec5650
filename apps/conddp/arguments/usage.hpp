#pragma once

#include <string>

#include "arguments/command_words.hpp"
#include "base/text/diagnostic.hpp"

namespace conddp {

/// What is wrong with a command line of `tool`, where the parser ended with this message: with
/// suggestions for misspelt subcommands, flags and values.
Diagnostic usage_error(const Command& tool, const CommandWords& words, std::string message);

}  // namespace conddp
