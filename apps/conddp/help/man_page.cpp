
#include <algorithm>

#include <fmt/format.h>

#include "conddp_version.hpp"
#include "help/help.hpp"
#include "terminal/environment.hpp"

namespace conddp {
namespace {

/// Text escaped for roff: '-' remains a hyphen-minus, and no line begins with a control character.
std::string roff_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '.' && (out.empty() || out.back() == '\n')) out += "\\&";
    if (c == '\'')
      out += "\\(aq";
    else if (c == '\\' || c == '-')
      out += c == '-' ? "\\-" : "\\e";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string man_page_name(const Command& command) {
  std::string name = command.name;
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

std::string man_page(const Command& command) {
  constexpr int kWidth = 72;
  const std::string name = roff_text(man_page_name(command));
  std::string text = fmt::format(
      ".TH \"{}\" \"1\" \"\" \"conddp {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH "
      "DESCRIPTION\n.nf\n{}.fi\n.SH ENVIRONMENT\n",
      name, build_info().version, name, roff_text(command.description),
      roff_text(help_text(command, kWidth)));
  for (const EnvironmentInfo& info : kEnvironment)
    text += fmt::format(".TP\n{}\n{}\n", roff_text(info.name), roff_text(info.meaning));
  return text;
}

}  // namespace conddp
