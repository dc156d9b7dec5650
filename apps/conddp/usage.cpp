#include "usage.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "base/spelling.hpp"
#include "command_doc.hpp"

namespace conddp {
namespace {

Diagnostic with_names(std::string message, std::string_view wrong, std::vector<std::string> names,
                      std::string_view what) {
  return {.message = std::move(message),
          .hint = name_hint(wrong, names, what),
          .accepted = std::move(names)};
}

std::vector<std::string> flags_of(const CommandDoc& command) {
  std::vector<std::string> names;
  for (const OptionDoc& option : command.options)
    for (const std::string& name : option.names)
      if (name.starts_with("--")) names.push_back(name);
  return names;
}

std::vector<std::string> names_of(const std::vector<CommandDoc>& commands) {
  std::vector<std::string> names;
  for (const CommandDoc& command : commands) names.push_back(command.short_name());
  return names;
}

/// What a person calls an option: "--solver", "KIND".
std::string called(const OptionDoc& option) {
  return option.positional ? option.value : option.names.back();
}

/// The first value that is none of its option's words.
std::optional<Diagnostic> wrong_word(const CommandWords& words) {
  for (const auto& [option, value] : words.values) {
    const OptionDoc doc = describe(*option);
    if (doc.choices.empty()) continue;
    if (std::find(doc.choices.begin(), doc.choices.end(), value) != doc.choices.end()) continue;
    return with_names(fmt::format("{}: there is no '{}'", called(doc), value), value, doc.choices,
                      "accepted");
  }
  return std::nullopt;
}

std::string parser_message(const CLI::ParseError& error) {
  std::string text = error.what();
  // A sentence of the parser's begins with a capital, ours go on after "error:".
  if (text.size() > 1 && std::isupper(static_cast<unsigned char>(text[0])) &&
      std::islower(static_cast<unsigned char>(text[1])))
    text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

}  // namespace

Diagnostic usage_error(const CLI::App& app, const CLI::ParseError& error,
                       const CommandWords& words) {
  const CommandDoc command = describe(*words.command);
  if (!words.unknown_command.empty())
    return with_names(fmt::format("unknown subcommand '{}'", words.unknown_command),
                      words.unknown_command, names_of(command.commands), "subcommands");
  if (!words.unknown_flag.empty())
    return with_names(fmt::format("unknown option '{}'", words.unknown_flag), words.unknown_flag,
                      flags_of(command), "options");
  if (auto wrong = wrong_word(words)) return *wrong;
  if (words.incomplete != nullptr) {
    const OptionDoc option = describe(*words.incomplete);
    return {.message = fmt::format("{} needs a value", called(option)),
            .hint = fmt::format("write '{} {}': {}", called(option), option.value,
                                option.explanation()),
            .accepted = option.choices};
  }
  if (words.command == &app)
    return with_names("a subcommand is required", "", names_of(command.commands), "subcommands");
  if (!words.extra.empty())
    return {.message = fmt::format("'{}' is one argument too many", words.extra),
            .hint = "usage: " + command.usage()};
  for (const OptionDoc& positional : command.positionals) {
    const bool given = std::any_of(words.values.begin(), words.values.end(), [&](const auto& v) {
      return describe(*v.first).names == positional.names;
    });
    if (positional.required && !given)
      return {
          .message = fmt::format("{} is required: {}", positional.value, positional.description),
          .hint = "usage: " + command.usage()};
  }
  return {.message = parser_message(error)};
}

}  // namespace conddp
