#pragma once

#include <string>

#include "arguments/command.hpp"

namespace conddp {

/// How the reading of a command line ended.
struct ParseEnd {
  enum class Kind { kCommand, kHelp, kVersion, kError };
  Kind kind = Kind::kCommand;
  std::string message;  ///< of an error: a clause, as the parser puts it
};

/// Reads a command line (argv[0] is the program) into the variables of the arguments of `tool` and
/// of the subcommand that it names; variables of options that are not given keep their values.
/// `named` is that subcommand by CommandWords, or the tool: options of others are not declared.
ParseEnd parse(const Command& tool, const Command& named, int argc, const char* const* argv);

}  // namespace conddp
