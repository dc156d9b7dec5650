#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace conddp {

/// A flag that ends the command line: the parser ignores everything after it.
enum class EndingFlag { kHelp, kVersion };

/// Destination of an argument's value. A bool makes the argument a flag, a list accepts any number
/// of values. Without a variable, only `CommandWords` contains the value.
using ArgumentTarget = std::variant<std::monostate, bool*, std::string*, std::vector<std::string>*,
                                    int*, std::optional<int>*, std::uint64_t*, double*, EndingFlag>;

/// Returns the defect of a value, or an empty text.
using ArgumentCheck = std::function<std::string(const std::string& value)>;

/// Integers from `least` to `most`.
struct WholeNumbers {
  long long least;
  long long most;
};

/// An option or positional argument of a command. The parser, help, manual pages and completion use
/// only this declaration.
struct Argument {
  /// Examples: "-o", "--output"; a single name without a dash is positional: "FILE".
  std::vector<std::string> names;
  /// Name of the value, empty for a flag. "FOLDER" denotes a folder, a name with suffixes
  /// ("FILE.json", "FILE.csv.json") a file; neither may be empty.
  std::string value;
  std::string description;
  std::vector<std::string> choices;     ///< accepted words; empty: any
  std::optional<WholeNumbers> numbers;  ///< accepted numbers
  ArgumentCheck check;                  ///< further condition on a value
  std::string fallback;                 ///< shown as the default value
  /// Value of an option that may stand alone; one of `choices` may follow it.
  std::string implied;
  std::string needs;     ///< an option that must also be given
  std::string excludes;  ///< an option that must not be given with this one
  bool required = false;
  ArgumentTarget target;

  bool positional() const { return !names.front().starts_with('-'); }
  /// True if the next word need not be a value.
  bool flag() const { return value.empty() || !implied.empty(); }
  bool repeatable() const { return std::holds_alternative<std::vector<std::string>*>(target); }
  bool folder() const { return value == "FOLDER"; }
  /// Suffixes of the accepted files, with the dot.
  std::vector<std::string> suffixes() const;
  /// Name for users: "--output", "FILE.yaml".
  const std::string& called() const { return positional() ? value : names.back(); }

  /// "-o, --output FOLDER", or for a positional argument its form on the command line: "[KIND]".
  std::string heading() const;
  /// The description with choices, numbers and default.
  std::string explanation() const;
};

/// A flag that sets a variable.
Argument flag(std::vector<std::string> names, bool& target, std::string description,
              std::string excludes = {});

/// The program or one of its subcommands.
struct Command {
  std::string name;  ///< with those above it: "conddp solve"
  std::string description;
  std::string details;  ///< paragraphs, may be empty
  std::vector<Argument> arguments;
  std::vector<Command> commands;
  /// Runs the subcommand with the parsed values of its arguments; returns the exit code.
  std::function<int()> run;

  std::vector<const Argument*> positionals() const;
  std::vector<const Argument*> options() const;
  /// Name without its parents: "solve".
  std::string short_name() const { return name.substr(name.rfind(' ') + 1); }
  /// The subcommand of this short name, or null.
  const Command* find(const std::string& short_name) const;
  /// Example: "conddp solve [OPTIONS] FILE.yaml".
  std::string usage() const;
};

}  // namespace conddp
