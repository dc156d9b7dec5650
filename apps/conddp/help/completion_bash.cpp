#include <fmt/format.h>
#include <fmt/ranges.h>

#include "help/help.hpp"

namespace conddp {
namespace {

/// Action of the script's case for a value.
std::string bash_action(const Argument& option) {
  if (!option.choices.empty()) return fmt::format("words='{}'", fmt::join(option.choices, " "));
  if (option.folder()) return "folders=1";
  if (const auto suffixes = option.suffixes(); !suffixes.empty())
    return fmt::format("folders=1 suffixes='{}'", fmt::join(suffixes, " "));
  return ":";
}

std::vector<std::string> flags(const Command& command) {
  std::vector<std::string> names;
  for (const Argument* option : command.options())
    names.insert(names.end(), option->names.begin(), option->names.end());
  return names;
}

/// Cases "<subcommand> <flag>" for flags with a value, with the actions from `make`.
template <class Make>
std::string value_cases(const Command& command, const std::string& name, const Make& make) {
  std::string text;
  for (const Argument* option : command.options()) {
    if (option->flag()) continue;
    std::vector<std::string> patterns;
    for (const std::string& flag : option->names)
      patterns.push_back(fmt::format("'{} {}'", name, flag));
    text += fmt::format("      {}) {} ;;\n", fmt::join(patterns, " | "), make(*option));
  }
  return text;
}

template <class Make>
std::string all_value_cases(const Command& root, const Make& make) {
  std::string text = value_cases(root, "", make);
  for (const Command& command : root.commands)
    text += value_cases(command, command.short_name(), make);
  return text;
}

}  // namespace

std::string bash_completion(const Command& root) {
  std::vector<std::string> names;
  for (const Command& command : root.commands) names.push_back(command.short_name());
  std::string flag_cases = fmt::format("      '') words='{}' ;;\n", fmt::join(flags(root), " "));
  std::string places = fmt::format("      ' 0') words='{}' ;;\n", fmt::join(names, " "));
  for (const Command& command : root.commands) {
    flag_cases += fmt::format("      {}) words='{}' ;;\n", command.short_name(),
                              fmt::join(flags(command), " "));
    const auto positionals = command.positionals();
    for (std::size_t i = 0; i < positionals.size(); ++i)
      places += fmt::format("      '{} '{}) {} ;;\n", command.short_name(),
                            positionals[i]->repeatable() ? "*" : std::to_string(i),
                            bash_action(*positionals[i]));
  }
  const auto waits = [](const Argument&) { return "flag=$word"; };
  return fmt::format(R"(# bash completion of conddp, written by 'conddp completion bash'
_conddp() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} command='' flag='' place=0 words='' folders='' suffixes=''
  local i word suffix
  # The words before: the subcommand, how many arguments, and whether a flag waits for its value.
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=${{COMP_WORDS[i]}}
    [[ $word == '=' ]] && continue
    if [[ -n $flag ]]; then
      flag=''
      continue
    fi
    case "$command $word" in
{}      *' -'*) ;;
      ' '*) command=$word ;;
      *) ((++place)) ;;
    esac
  done
  [[ $current == '=' ]] && current=''
  if [[ -n $flag ]]; then
    case "$command $flag" in
{}    esac
  elif [[ $current == -* ]]; then
    case "$command" in
{}    esac
  else
    case "$command $place" in
{}    esac
  fi
  COMPREPLY=()
  if [[ -n $words ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  elif [[ -n $folders ]]; then
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(
      compgen -d -- "$current"
      for suffix in $suffixes; do compgen -f -X "!*$suffix" -- "$current"; done
    )
  fi
}}
complete -F _conddp conddp
)",
                     all_value_cases(root, waits), all_value_cases(root, bash_action), flag_cases,
                     places);
}

}  // namespace conddp
