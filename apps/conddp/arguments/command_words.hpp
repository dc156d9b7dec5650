#pragma once

#include <string>
#include <utility>
#include <vector>

#include "arguments/command.hpp"

namespace conddp {

/// What the words of a command line are to a parser, whether or not they are acceptable.
struct CommandWords {
  const Command* command;       ///< the subcommand named, else the whole
  std::string unknown_command;  ///< the word where a subcommand is expected
  std::string unknown_flag;     ///< the first one
  std::string extra;            ///< the first positional argument too many
  /// Options and positional arguments with their values, in order.
  std::vector<std::pair<const Argument*, std::string>> values;
  const Argument* incomplete = nullptr;  ///< the last option, where its value is missing

  /// The last value of an option by its longest name, empty if there is none.
  std::string value_of(const std::string& option) const;
};

/// Reads the words behind the program's name. The result refers to `tool`.
CommandWords read_words(const Command& tool, const std::vector<std::string>& arguments);

}  // namespace conddp
