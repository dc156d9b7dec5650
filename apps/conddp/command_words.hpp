#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace conddp {

/// What the words of a command line are to a parser, whether or not they are acceptable.
struct CommandWords {
  const CLI::App* command;      ///< the subcommand named, else the whole
  std::string unknown_command;  ///< the word where a subcommand is expected
  std::string unknown_flag;     ///< the first one
  std::string extra;            ///< the first positional argument too many
  /// Options and positional arguments with their values, in order.
  std::vector<std::pair<const CLI::Option*, std::string>> values;
  const CLI::Option* incomplete = nullptr;  ///< the last option, where its value is missing

  /// The last value of a long option (without dashes), empty if there is none.
  std::string value_of(const std::string& option) const;
};

CommandWords read_words(const CLI::App& app, const std::vector<std::string>& arguments);

}  // namespace conddp
