#pragma once

#include <string>

#include "arguments/command.hpp"

namespace conddp {

/// Result of parsing a command line.
struct ParseEnd {
  enum class Kind { kCommand, kHelp, kVersion, kError };
  Kind kind = Kind::kCommand;
  std::string message;  ///< for an error: a clause in the parser's wording
};

/// Parses a command line (argv[0] is the program) into the variables of the arguments of `tool` and
/// of the named subcommand. Variables of options that are not given keep their values. `named` is
/// the subcommand from CommandWords, or the tool; options of other subcommands are not declared.
ParseEnd parse(const Command& tool, const Command& named, int argc, const char* const* argv);

}  // namespace conddp
