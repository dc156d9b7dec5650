#include <fmt/format.h>
#include <fmt/ranges.h>

#include "help/help.hpp"

namespace conddp {
namespace {

/// Text inside a specification of _arguments, between single quotes.
std::string zsh_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
      continue;
    }
    if (c == ':' || c == '[' || c == ']' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

/// ":message:action" for a value.
std::string zsh_action(const Argument& option) {
  const std::string message = ":" + zsh_text(option.value);
  if (!option.choices.empty())
    return fmt::format("{}:({})", message, fmt::join(option.choices, " "));
  if (option.folder()) return message + ":_files -/";
  const std::vector<std::string> suffixes = option.suffixes();
  // After a pattern, zsh does not treat brackets without '|' as a group.
  if (suffixes.size() == 1) return fmt::format("{}:_files -g \"*{}\"", message, suffixes[0]);
  if (!suffixes.empty())
    return fmt::format("{}:_files -g \"*({})\"", message, fmt::join(suffixes, "|"));
  return message + ": ";
}

/// Specification of an option by one of its names.
std::string specification(const Argument& option, const std::string& name) {
  const std::string others =
      option.repeatable() ? "*" : fmt::format("({})", fmt::join(option.names, " "));
  const bool equals = !option.flag() && name.starts_with("--");
  return fmt::format("'{}{}{}[{}]{}'", others, name, equals ? "=" : "",
                     zsh_text(option.description), option.flag() ? "" : zsh_action(option));
}

std::string specifications(const Command& command, const std::string& margin) {
  std::string text;
  for (const Argument* option : command.options())
    for (const std::string& name : option->names)
      text += fmt::format("{}{} \\\n", margin, specification(*option, name));
  const auto positionals = command.positionals();
  for (std::size_t i = 0; i < positionals.size(); ++i)
    text += fmt::format("{}'{}{}' \\\n", margin,
                        positionals[i]->repeatable() ? "*" : std::to_string(i + 1),
                        zsh_action(*positionals[i]));
  return text;
}

}  // namespace

std::string zsh_completion(const Command& root) {
  std::string commands, cases;
  for (const Command& command : root.commands) {
    commands += fmt::format("    '{}:{}'\n", command.short_name(), zsh_text(command.description));
    cases += fmt::format("    {})\n      _arguments \\\n{}        && ret=0\n      ;;\n",
                         command.short_name(), specifications(command, "        "));
  }
  return fmt::format(R"(#compdef conddp
# zsh completion of conddp, written by 'conddp completion zsh'
_conddp() {{
  local curcontext=$curcontext state state_descr line ret=1
  typeset -A opt_args
  local -a commands=(
{}  )
  _arguments -C \
{}    '1: :->command' \
    '*:: :->arguments' \
    && ret=0
  case $state in
    command) _describe -t commands subcommand commands && ret=0 ;;
    arguments)
      curcontext=${{curcontext%:*:*}}:conddp-$words[1]:
      case $words[1] in
{}      esac
      ;;
  esac
  return ret
}}
if [[ $funcstack[1] == _conddp ]]; then
  _conddp "$@"
else
  compdef _conddp conddp
fi
)",
                     commands, specifications(root, "    "), cases);
}

}  // namespace conddp
