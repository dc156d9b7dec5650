#include "arguments/parser.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <type_traits>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text/strict_number.hpp"

namespace conddp {
namespace {

std::string number_defect(const WholeNumbers& numbers, const std::string& value) {
  const std::string accepted = fmt::format("; accepted: {} to {}", numbers.least, numbers.most);
  if (const ParsedNumber number = parse_number(value); !number.value)
    return number.defect + accepted;
  long long whole = 0;
  const auto [stop, code] = std::from_chars(value.data(), value.data() + value.size(), whole);
  if (stop != value.data() + value.size())
    return fmt::format("'{}' is not a whole number{}", value, accepted);
  if (code != std::errc() || whole < numbers.least || whole > numbers.most)
    return fmt::format("'{}' is out of range{}", value, accepted);
  return {};
}

/// True if a value is one of an argument's choices, or any value is accepted.
bool may_be(const Argument& argument, const std::string& value) {
  const auto& choices = argument.choices;
  return choices.empty() || std::find(choices.begin(), choices.end(), value) != choices.end();
}

/// The defect of an argument's value; empty if valid.
std::string defect(const Argument& argument, const std::string& value) {
  if (!may_be(argument, value)) return fmt::format("there is no '{}'", value);
  // An empty text is not a path; the shell produces it from an unset variable.
  if (value.empty() && (argument.folder() || !argument.suffixes().empty()))
    return "the value is empty";
  if (argument.numbers)
    if (std::string found = number_defect(*argument.numbers, value); !found.empty()) return found;
  return argument.check ? argument.check(value) : std::string();
}

/// Adds an argument to the CLI11 parser, bound to its variable.
void add(CLI::App& app, const Argument& argument) {
  const std::string names = fmt::format("{}", fmt::join(argument.names, ","));
  CLI::Option* option = std::visit(
      [&](auto target) -> CLI::Option* {
        using Target = decltype(target);
        if constexpr (std::is_same_v<Target, std::monostate>)
          return app.add_option(names);
        else if constexpr (std::is_same_v<Target, bool*>)
          return app.add_flag(names, *target);
        else if constexpr (std::is_same_v<Target, EndingFlag>)
          return target == EndingFlag::kHelp ? app.set_help_flag(names)
                                             : app.set_version_flag(names);
        else
          return app.add_option(names, *target);
      },
      argument.target);
  if (argument.value.empty()) return;
  option->required(argument.required);
  if (argument.repeatable() && !argument.positional()) option->allow_extra_args(false);
  option->check([&argument](const std::string& value) { return defect(argument, value); });
}

void add_all(CLI::App& app, const Command& command) {
  app.set_help_flag();
  for (const Argument& argument : command.arguments) add(app, argument);
  for (const Argument& argument : command.arguments) {
    CLI::Option* option = app.get_option(argument.names.back());
    if (!argument.needs.empty()) option->needs(app.get_option(argument.needs));
    if (!argument.excludes.empty()) option->excludes(app.get_option(argument.excludes));
  }
}

/// Converts a parser sentence to a clause: the parser capitalizes sentences, but ours follow
/// "error:".
std::string clause(std::string text) {
  if (text.size() > 1 && std::isupper(static_cast<unsigned char>(text[0])) &&
      std::islower(static_cast<unsigned char>(text[1])))
    text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

/// Writes the value of each option that may stand alone behind it: `--expand gait` and `--expand`
/// become `--expand=gait` and `--expand=mesh`.
std::vector<std::string> with_implied(const Command& command, int argc, const char* const* argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  for (std::size_t i = 0; i < words.size(); ++i)
    for (const Argument& argument : command.arguments) {
      const auto& names = argument.names;
      if (argument.implied.empty() || std::ranges::find(names, words[i]) == names.end()) continue;
      const bool given = i + 1 < words.size() && may_be(argument, words[i + 1]);
      words[i] += "=" + (given ? words[i + 1] : argument.implied);
      if (given) words.erase(words.begin() + i + 1);
    }
  return words;
}

}  // namespace

ParseEnd parse(const Command& tool, const Command& named, int argc, const char* const* argv) {
  CLI::App app(tool.description, tool.name);
  add_all(app, tool);
  for (const Command& command : tool.commands) {
    CLI::App* const subcommand = app.add_subcommand(command.short_name());
    if (&command == &named) add_all(*subcommand, command);
  }
  app.require_subcommand(1);
  try {
    std::vector<std::string> words = with_implied(named, argc, argv);
    std::ranges::reverse(words);
    app.parse(std::move(words));
  } catch (const CLI::CallForHelp&) {
    return {.kind = ParseEnd::Kind::kHelp};
  } catch (const CLI::CallForVersion&) {
    return {.kind = ParseEnd::Kind::kVersion};
  } catch (const CLI::ParseError& error) {
    return {.kind = ParseEnd::Kind::kError, .message = clause(error.what())};
  }
  return {};
}

}  // namespace conddp
