#pragma once

#include <string>
#include <utility>
#include <vector>

#include "arguments/command.hpp"

namespace conddp {

/// Roles of the words on a command line, whether or not they are acceptable.
struct CommandWords {
  const Command* command;       ///< the named subcommand, else the tool
  std::string unknown_command;  ///< a word in place of a subcommand
  std::string unknown_flag;     ///< the first unknown one
  std::string extra;            ///< first excess positional argument
  /// Options and positional arguments with their values, in order.
  std::vector<std::pair<const Argument*, std::string>> values;
  const Argument* incomplete = nullptr;  ///< the last option, if its value is missing

  /// The last value of an option by its longest name, empty if not given.
  std::string value_of(const std::string& option) const;
};

/// Reads the words after the program's name. The result refers to `tool`.
CommandWords read_words(const Command& tool, const std::vector<std::string>& arguments);

}  // namespace conddp
