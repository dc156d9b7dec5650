#include "arguments/command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace conddp {

std::vector<std::string> Argument::suffixes() const {
  std::vector<std::string> list;
  for (std::size_t dot = value.find('.'); dot != std::string::npos;) {
    const std::size_t next = value.find('.', dot + 1);
    list.push_back(value.substr(dot, next - dot));
    dot = next;
  }
  return list;
}

std::string Argument::heading() const {
  if (positional()) {
    const std::string word = value + (repeatable() ? "..." : "");
    return required ? word : fmt::format("[{}]", word);
  }
  const char* form = value.empty() ? "{}" : implied.empty() ? "{} {}" : "{} [{}]";
  return fmt::format(fmt::runtime(form), fmt::join(names, ", "), value);
}

std::string Argument::explanation() const {
  std::string text = description;
  if (!choices.empty()) text += fmt::format(": {}", fmt::join(choices, ", "));
  if (numbers) text += fmt::format(" [{} - {}]", numbers->least, numbers->most);
  if (!fallback.empty()) text += fmt::format(" (default: {})", fallback);
  if (repeatable() && !positional()) text += " (repeatable)";
  return text;
}

Argument flag(std::vector<std::string> names, bool& target, std::string description,
              std::string excludes) {
  return {.names = std::move(names),
          .description = std::move(description),
          .excludes = std::move(excludes),
          .target = &target};
}

std::vector<const Argument*> Command::positionals() const {
  std::vector<const Argument*> list;
  for (const Argument& argument : arguments)
    if (argument.positional()) list.push_back(&argument);
  return list;
}

std::vector<const Argument*> Command::options() const {
  std::vector<const Argument*> list;
  for (const Argument& argument : arguments)
    if (!argument.positional()) list.push_back(&argument);
  return list;
}

const Command* Command::find(const std::string& short_name) const {
  for (const Command& command : commands)
    if (command.short_name() == short_name) return &command;
  return nullptr;
}

std::string Command::usage() const {
  std::string text = name + " [OPTIONS]";
  if (!commands.empty()) text += " SUBCOMMAND";
  for (const Argument* positional : positionals()) text += " " + positional->heading();
  return text;
}

}  // namespace conddp
