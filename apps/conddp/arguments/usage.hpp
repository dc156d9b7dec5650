#pragma once

#include <string>

#include "arguments/command_words.hpp"
#include "base/text/diagnostic.hpp"

namespace conddp {

/// The error in a command line of `tool`, given the parser's message, with suggestions for
/// misspelled subcommands, flags and values.
Diagnostic usage_error(const Command& tool, const CommandWords& words, std::string message);

}  // namespace conddp
