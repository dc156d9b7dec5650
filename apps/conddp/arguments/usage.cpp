#include "arguments/usage.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/text/spelling.hpp"

namespace conddp {
namespace {

Diagnostic with_names(std::string message, std::string_view wrong, std::vector<std::string> names,
                      std::string_view what) {
  return {.message = std::move(message),
          .hint = name_hint(wrong, names, what),
          .accepted = std::move(names)};
}

std::vector<std::string> flags_of(const Command& command) {
  std::vector<std::string> names;
  for (const Argument* option : command.options())
    for (const std::string& name : option->names)
      if (name.starts_with("--")) names.push_back(name);
  return names;
}

std::vector<std::string> names_of(const std::vector<Command>& commands) {
  std::vector<std::string> names;
  for (const Command& command : commands) names.push_back(command.short_name());
  return names;
}

/// The first value that is not among its option's choices.
std::optional<Diagnostic> wrong_word(const CommandWords& words) {
  for (const auto& [option, value] : words.values) {
    const std::vector<std::string>& choices = option->choices;
    if (choices.empty()) continue;
    if (std::find(choices.begin(), choices.end(), value) != choices.end()) continue;
    return with_names(fmt::format("{}: there is no '{}'", option->called(), value), value, choices,
                      "accepted");
  }
  return std::nullopt;
}

/// The first missing required argument, or null.
const Argument* lacking_argument(const CommandWords& words) {
  for (const Argument* positional : words.command->positionals()) {
    const bool given = std::any_of(words.values.begin(), words.values.end(),
                                   [&](const auto& value) { return value.first == positional; });
    if (positional->required && !given) return positional;
  }
  return nullptr;
}

}  // namespace

Diagnostic usage_error(const Command& tool, const CommandWords& words, std::string message) {
  const Command& command = *words.command;
  if (!words.unknown_command.empty())
    return with_names(fmt::format("unknown subcommand '{}'", words.unknown_command),
                      words.unknown_command, names_of(command.commands), "subcommands");
  if (!words.unknown_flag.empty())
    return with_names(fmt::format("unknown option '{}'", words.unknown_flag), words.unknown_flag,
                      flags_of(command), "options");
  if (auto wrong = wrong_word(words)) return *wrong;
  if (words.incomplete != nullptr) {
    const Argument& option = *words.incomplete;
    return {.message = fmt::format("{} needs a value", option.called()),
            .hint = fmt::format("write '{} {}': {}", option.called(), option.value,
                                option.explanation()),
            .accepted = option.choices};
  }
  if (words.command == &tool)
    return with_names("a subcommand is required", "", names_of(command.commands), "subcommands");
  if (!words.extra.empty())
    return {.message = fmt::format("unexpected argument '{}'", words.extra),
            .hint = "usage: " + command.usage()};
  if (const Argument* lacking = lacking_argument(words))
    return {.message = fmt::format("{} is required: {}", lacking->value, lacking->description),
            .hint = "usage: " + command.usage()};
  return {.message = std::move(message)};
}

}  // namespace conddp
