#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace conddp {

/// A flag that ends the command line: what follows it is not read.
enum class EndingFlag { kHelp, kVersion };

/// Where the value of an argument goes. A bool makes it a flag, a list takes any number of values;
/// of an argument without a variable only `CommandWords` has the value.
using ArgumentTarget = std::variant<std::monostate, bool*, std::string*, std::vector<std::string>*,
                                    int*, std::optional<int>*, std::uint64_t*, double*, EndingFlag>;

/// What is wrong with a value; empty where nothing is.
using ArgumentCheck = std::function<std::string(const std::string& value)>;

/// Whole numbers from `least` to `most`.
struct WholeNumbers {
  long long least;
  long long most;
};

/// An option or positional argument of a command. The parser, help, manual pages and completion
/// read this declaration and nothing else.
struct Argument {
  /// "-o", "--output"; a single name without a dash makes it positional: "FILE".
  std::vector<std::string> names;
  /// What the value is called, empty for a flag. "FOLDER" stands for a folder, a name that ends in
  /// suffixes ("FILE.json", "FILE.csv.json") for a file; neither may be empty.
  std::string value;
  std::string description;
  std::vector<std::string> choices;     ///< the words accepted, empty: any
  std::optional<WholeNumbers> numbers;  ///< the numbers accepted
  ArgumentCheck check;                  ///< what else a value must satisfy
  std::string fallback;                 ///< shown as the value without the option
  std::string needs;                    ///< an option that must be given as well
  std::string excludes;                 ///< an option that must not be given as well
  bool required = false;
  ArgumentTarget target;

  bool positional() const { return !names.front().starts_with('-'); }
  bool flag() const { return value.empty(); }
  bool repeatable() const { return std::holds_alternative<std::vector<std::string>*>(target); }
  bool folder() const { return value == "FOLDER"; }
  /// Those of the files accepted, with the dot.
  std::vector<std::string> suffixes() const;
  /// What a person calls it: "--output", "FILE.yaml".
  const std::string& called() const { return positional() ? value : names.back(); }

  /// "-o, --output FOLDER", or of a positional what stands on the command line: "[KIND]".
  std::string heading() const;
  /// The description with choices, numbers and default.
  std::string explanation() const;
};

/// A flag that sets a variable.
Argument flag(std::vector<std::string> names, bool& target, std::string description,
              std::string excludes = {});

/// The program, or one of its subcommands.
struct Command {
  std::string name;  ///< with those above it: "conddp solve"
  std::string description;
  std::string details;  ///< paragraphs, may be empty
  std::vector<Argument> arguments;
  std::vector<Command> commands;
  /// Runs the subcommand with the values that its arguments have got; returns the exit code.
  std::function<int()> run;

  std::vector<const Argument*> positionals() const;
  std::vector<const Argument*> options() const;
  /// Without those above it: "solve".
  std::string short_name() const { return name.substr(name.rfind(' ') + 1); }
  /// The subcommand of this short name, or null.
  const Command* find(const std::string& short_name) const;
  /// "conddp solve [OPTIONS] FILE.yaml"
  std::string usage() const;
};

}  // namespace conddp
