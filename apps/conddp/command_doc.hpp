#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace conddp {

/// An option or positional argument as help, manual pages and completion show it.
struct OptionDoc {
  std::vector<std::string> names;  ///< "-o", "--output"; of a positional its name
  std::string value;               ///< what the value is called, empty for a flag: "FOLDER"
  std::string description;
  std::string range;                  ///< of numbers: "[1 - 1024]"
  std::string fallback;               ///< value without the option, may be empty
  std::vector<std::string> choices;   ///< the words accepted, empty: any
  std::vector<std::string> suffixes;  ///< of the files accepted, with the dot
  bool folder = false;                ///< the value is a folder
  bool positional = false;
  bool required = false;
  bool repeatable = false;

  /// "-o, --output FOLDER", or of a positional what stands on the command line: "[KIND]".
  std::string heading() const;
  /// The description with choices, range and default.
  std::string explanation() const;
};

/// A command as its parser knows it.
struct CommandDoc {
  std::string name;  ///< with those above it: "conddp solve"
  std::string description;
  std::string details;  ///< paragraphs, may be empty
  std::vector<OptionDoc> positionals;
  std::vector<OptionDoc> options;
  std::vector<CommandDoc> commands;

  /// Without those above it: "solve".
  std::string short_name() const;
  /// "conddp solve [OPTIONS] FILE.yaml"
  std::string usage() const;
};

/// Everything about a command is read from its parser. What the value of an option is follows from
/// its type name: FOLDER is a folder, a name that ends in suffixes ("FILE.json", "FILE.csv.json") a
/// file; words come from CLI::IsMember.
CommandDoc describe(const CLI::App& app);
OptionDoc describe(const CLI::Option& option);

}  // namespace conddp
