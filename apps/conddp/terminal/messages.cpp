#include "terminal/messages.hpp"

#include <utility>

#include <nlohmann/json.hpp>

#include "base/text/utf8.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

MessageFormat g_format = MessageFormat::kText;

std::string json_line(const Diagnostic& d) {
  using Json = nlohmann::ordered_json;
  const auto position = [](int number) { return number > 0 ? Json(number) : Json(); };
  const Json json = {{"file", d.file.empty() ? Json() : Json(d.file)},
                     {"line", position(d.line)},
                     {"column", position(d.line > 0 ? d.column : 0)},
                     {"path", d.path},
                     {"severity", severity_name(d.severity)},
                     {"message", d.message},
                     {"hint", d.hint},
                     {"accepted", d.accepted}};
  return terminal_text(json.dump(-1, ' ', false, Json::error_handler_t::replace)) + "\n";
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
