#include <fmt/format.h>
#include <fmt/ranges.h>

#include "help/help.hpp"

namespace conddp {
namespace {

std::string literal(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

/// The part of a `complete` command with the possible values.
std::string values(const Argument& option) {
  if (!option.choices.empty())
    return " -x -a " + literal(fmt::format("{}", fmt::join(option.choices, " ")));
  if (option.folder()) return " -x -a '(__fish_complete_directories)'";
  const std::vector<std::string> suffixes = option.suffixes();
  if (suffixes.empty()) return " -x";
  std::string text;
  for (const std::string& suffix : suffixes)
    text += fmt::format("{}(__fish_complete_suffix {})", text.empty() ? "" : " ", suffix);
  return " -x -a " + literal(text);
}

std::string options(const Command& command, const std::string& condition) {
  std::string text;
  for (const Argument* option : command.options()) {
    text += "complete -c conddp -n " + condition;
    for (const std::string& name : option->names)
      text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (!option->flag()) text += values(*option);
    text += " -d " + literal(option->description) + "\n";
  }
  for (const Argument* positional : command.positionals())
    text += "complete -c conddp -n " + condition + values(*positional) + " -d " +
            literal(positional->value) + "\n";
  return text;
}

}  // namespace

std::string fish_completion(const Command& root) {
  std::vector<std::string> with_value;
  for (const Argument* option : root.options())
    if (!option->flag())
      with_value.insert(with_value.end(), option->names.begin(), option->names.end());
  std::string text = fmt::format(R"(# fish completion of conddp, written by 'conddp completion fish'
# Whether the subcommand on the command line is this one; without an argument: whether there is none.
function __conddp_uses
    set -l words (commandline -opc)
    set -l skip no
    for word in $words[2..-1]
        if test $skip = yes
            set skip no
        else if contains -- $word {}
            set skip yes
        else if not string match -q -- '-*' $word
            test "$word" = "$argv[1]"
            return
        end
    end
    test -z "$argv[1]"
end
complete -c conddp -f
)",
                                 fmt::join(with_value, " "));
  text += options(root, "__conddp_uses");
  for (const Command& command : root.commands) {
    text += fmt::format("complete -c conddp -n __conddp_uses -a {} -d {}\n", command.short_name(),
                        literal(command.description));
    text += options(command, literal("__conddp_uses " + command.short_name()));
  }
  return text;
}

}  // namespace conddp
