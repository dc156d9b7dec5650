#include "terminal/messages.hpp"

#include <utility>

#include "base/json/diagnostic_json.hpp"
#include "base/text/utf8.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

MessageFormat g_format = MessageFormat::kText;

std::string json_line(const Diagnostic& d) {
  return terminal_text(compact_json(diagnostic_json(d))) + "\n";
}

std::string json_lines(const Diagnostics& diagnostics, Severity least) {
  std::string text;
  int errors = 0;
  for (const Diagnostic& d : diagnostics.list()) {
    errors += d.severity == Severity::kError;
    if (d.severity <= least) text += json_line(d);
  }
  if (const int more = diagnostics.error_count() - errors; more > 0)
    text += json_line({.message = std::to_string(more) + " more errors"});
  return text;
}

}  // namespace

void set_message_format(MessageFormat format) { g_format = format; }
MessageFormat message_format() { return g_format; }

void print_messages(const Diagnostics& diagnostics, Verbosity verbosity) {
  const Severity least = verbosity == Verbosity::kQuiet    ? Severity::kError
                         : verbosity == Verbosity::kNormal ? Severity::kWarning
                                                           : Severity::kNote;
  if (g_format == MessageFormat::kJson) return print_message(json_lines(diagnostics, least));
  constexpr int kErrorsShown = 20;
  const Terminal terminal = terminal_of(2);
  print_message(format_diagnostics(diagnostics, terminal.colour, least, kErrorsShown,
                                   terminal.message_width()));
}

void print_error(std::string message, std::string hint, std::vector<std::string> accepted) {
  Diagnostics diagnostics;
  diagnostics.error({}, std::move(message), std::move(hint), std::move(accepted));
  print_messages(diagnostics, Verbosity::kQuiet);
}

}  // namespace conddp
