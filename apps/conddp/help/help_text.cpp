#include <algorithm>

#include <fmt/format.h>

#include "base/text/text_layout.hpp"
#include "help/help.hpp"
#include "terminal/exit_codes.hpp"

namespace conddp {
namespace {

constexpr int kMargin = 2;

/// A heading with an explanation next to it, or below a long heading.
std::string entry(const std::string& heading, const std::string& explanation, int width) {
  const int column = std::clamp(width / 3, 8, 26);
  const int used = kMargin + shown_width(heading);
  if (used + 2 <= column)
    return wrap_text(fmt::format("{}{}{}", heading, std::string(column - used, ' '), explanation),
                     width, kMargin, column);
  return wrap_text(heading, width, kMargin, column) + wrap_text(explanation, width, column, column);
}

std::string list(const char* title, const std::vector<const Argument*>& options, int width) {
  if (options.empty()) return {};
  std::string text = fmt::format("\n{}:\n", title);
  for (const Argument* option : options) {
    // Long names are aligned, with or without a short name.
    const bool only_long = option->names.front().starts_with("--");
    text += entry((only_long ? "    " : "") + option->heading(), option->explanation(), width);
  }
  return text;
}

}  // namespace

std::string help_text(const Command& command, int width) {
  std::string text = wrap_text(command.description, width, 0, 0);
  text += "\n" + wrap_text("Usage: " + command.usage(), width, 0, 7);
  text += list("Arguments", command.positionals(), width);
  text += list("Options", command.options(), width);
  if (!command.details.empty()) text += "\n" + wrap_text(command.details, width, 0, 0);
  if (command.commands.empty()) return text;
  text += "\nSubcommands:\n";
  for (const Command& sub : command.commands)
    text += entry(sub.short_name(), sub.description, width);
  text += "\nExit status:\n";
  for (const ExitCodeInfo& info : kExitCodes)
    text += entry(fmt::format("{}", info.code), std::string(info.meaning), width);
  return text;
}

}  // namespace conddp
