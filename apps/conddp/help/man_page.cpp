#include "help/man_page.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "conddp_version.hpp"
#include "terminal/environment.hpp"
#include "terminal/exit_codes.hpp"

namespace conddp {
namespace {

std::string roff_character(char c) {
  switch (c) {
    case '\\':
      return "\\e";
    case '-':
      return "\\-";
    case '\'':
      return "\\(aq";
    default:
      return std::string(1, c);
  }
}

/// Text escaped for roff: '-' remains a hyphen-minus, and no line begins with a control character.
std::string roff_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool line_start = out.empty() || out.back() == '\n';
    if (line_start && (c == '.' || c == '\'')) out += "\\&";
    if (c != '\n')
      out += roff_character(c);
    else if (!line_start)
      out += "\n.br\n";
  }
  return out;
}

/// Paragraphs are separated by an empty line; line breaks within a paragraph are kept.
std::string paragraphs(std::string_view text) {
  std::string out;
  while (true) {
    const std::size_t end = text.find("\n\n");
    out += ".PP\n" + roff_text(text.substr(0, end)) + "\n";
    if (end == text.npos) return out;
    text.remove_prefix(end + 2);
  }
}

std::string bold(std::string_view text) { return "\\fB" + roff_text(text) + "\\fR"; }
std::string italic(std::string_view text) { return "\\fI" + roff_text(text) + "\\fR"; }

std::string heading(const Argument& option) {
  if (option.positional()) return italic(option.value);
  std::string text;
  for (const std::string& name : option.names) text += (text.empty() ? "" : ", ") + bold(name);
  return option.flag() ? text : text + " " + italic(option.value);
}

std::string tagged(const std::string& tag, std::string_view text) {
  return ".TP\n" + tag + "\n" + roff_text(text) + "\n";
}

std::string explanations(const std::vector<const Argument*>& arguments) {
  std::string text;
  for (const Argument* argument : arguments)
    text += tagged(heading(*argument), argument->explanation());
  return text;
}

std::string synopsis(const Command& command) {
  std::string text = bold(command.name) + " [" + italic("OPTIONS") + "]";
  if (!command.commands.empty()) text += " " + italic("SUBCOMMAND");
  for (const Argument* p : command.positionals())
    text += p->required ? " " + italic(p->value) : " [" + italic(p->value) + "]";
  return text + "\n";
}

std::string see_also(const Command& command, const Command& root) {
  std::string text;
  const auto add = [&](const Command& other) {
    if (other.name == command.name) return;
    text += (text.empty() ? "" : ", ") + bold(man_page_name(other)) + "(1)";
  };
  add(root);
  for (const Command& other : root.commands) add(other);
  return text + "\n";
}

}  // namespace

std::string man_page_name(const Command& command) {
  std::string name = command.name;
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

std::string man_page(const Command& command, const Command& root) {
  const std::string name = man_page_name(command);
  std::string title = name;
  std::transform(title.begin(), title.end(), title.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::string text = fmt::format(
      ".TH \"{}\" \"1\" \"\" \"conddp {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH "
      "SYNOPSIS\n{}",
      roff_text(title), build_info().version, roff_text(name), roff_text(command.description),
      synopsis(command));
  if (!command.details.empty()) text += ".SH DESCRIPTION\n" + paragraphs(command.details);
  if (const auto positionals = command.positionals(); !positionals.empty())
    text += ".SH ARGUMENTS\n" + explanations(positionals);
  text += ".SH OPTIONS\n" + explanations(command.options());
  if (!command.commands.empty()) {
    text += ".SH SUBCOMMANDS\n";
    for (const Command& sub : command.commands)
      text += tagged(bold(sub.short_name()), sub.description);
  }
  text += ".SH EXIT STATUS\n";
  for (const ExitCodeInfo& info : kExitCodes)
    text += tagged(bold(fmt::format("{}", info.code)), info.meaning);
  text += ".SH ENVIRONMENT\n";
  for (const EnvironmentInfo& info : kEnvironment) text += tagged(bold(info.name), info.meaning);
  return text + ".SH SEE ALSO\n" + see_also(command, root);
}

}  // namespace conddp
