#include "base/text/diagnostic.hpp"

#include <algorithm>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include "base/text/text_layout.hpp"
#include "base/text/utf8.hpp"

namespace conddp {
namespace {

/// `count` characters of a line from index `first`, with tabs as blanks.
std::string characters(std::string_view line, int first, int count) {
  std::string part;
  for (int character = -1; const char c : line) {
    if (starts_character(c) && ++character >= first + count) break;
    if (character >= first) part += c == '\t' || c == '\r' ? ' ' : c;
  }
  return part;
}

/// The source line with a caret under the column. Long lines are cropped around that column.
std::string excerpt(std::string_view line, int column, int room, const char* caret_start,
                    const char* caret_end) {
  constexpr int kMargin = 2, kEllipses = 6;
  const int width = room > 0 ? std::clamp(room - kMargin - kEllipses, 10, 100) : 100;
  const int count = count_characters(line);
  int first = 0;
  if (count > width) first = std::max(0, std::min(column - width / 2, count - width));
  const std::string shown = (first > 0 ? "..." : "") + masked(characters(line, first, width)) +
                            (first + width < count ? "..." : "");
  const int indent = (first > 0 ? 3 : 0) + column - 1 - first;
  return fmt::format("  {}\n  {}{}^{}\n", shown, std::string(std::max(indent, 0), ' '), caret_start,
                     caret_end);
}

/// True if the index of a text is valid; a mark from another collector may be out of range.
bool is_known(int source, std::size_t count) {
  return source >= 0 && static_cast<std::size_t>(source) < count;
}

}  // namespace

std::string_view Diagnostics::Source::line(int number) const {
  const int count = static_cast<int>(line_starts.size());
  if (number < 1 || number > count) return {};
  const std::size_t start = line_starts[number - 1];
  const std::size_t end = number < count ? line_starts[number] - 1 : text.size();
  std::string_view found = std::string_view(text).substr(start, end - start);
  if (found.ends_with('\r')) found.remove_suffix(1);
  return found;
}

int Diagnostics::add_source(std::string name, std::string text) {
  Source source{std::move(name), std::move(text), {0}};
  for (std::size_t i = 0; i < source.text.size(); ++i)
    if (source.text[i] == '\n') source.line_starts.push_back(i + 1);
  sources_.push_back(std::make_shared<const Source>(std::move(source)));
  return static_cast<int>(sources_.size()) - 1;
}

void Diagnostics::add_data_file(InputFile file) {
  const auto same = [&](const InputFile& other) {
    return other.file == file.file && other.sha256 == file.sha256;
  };
  if (std::none_of(data_files_.begin(), data_files_.end(), same))
    data_files_.push_back(std::move(file));
}

int Diagnostics::character_column(int source, int line, int byte) const {
  const std::string_view text = sources_[source]->line(line);
  return 1 + count_characters(text.substr(0, std::max(byte, 0)));
}

Diagnostic Diagnostics::at(const Place& place, Severity severity, std::string message,
                           std::string hint) const {
  const bool known = is_known(place.mark.source, sources_.size());
  return {.file = known ? sources_[place.mark.source]->name : std::string(),
          .line = known ? place.mark.line : 0,
          .column = known ? place.mark.column : 0,
          .path = place.path,
          .severity = severity,
          .message = std::move(message),
          .hint = std::move(hint),
          .source = known ? place.mark.source : -1};
}

void Diagnostics::error(const Place& place, std::string message, std::string hint,
                        std::vector<std::string> accepted) {
  Diagnostic diagnostic = at(place, Severity::kError, std::move(message), std::move(hint));
  diagnostic.accepted = std::move(accepted);
  add(std::move(diagnostic));
}

void Diagnostics::warning(const Place& place, std::string message, std::string hint) {
  add(at(place, Severity::kWarning, std::move(message), std::move(hint)));
}

void Diagnostics::note(const Place& place, std::string message, std::string hint) {
  add(at(place, Severity::kNote, std::move(message), std::move(hint)));
}

void Diagnostics::add(Diagnostic diagnostic) {
  if (diagnostic.severity == Severity::kError && ++errors_ > kMaxErrors) return;
  // Names from an input may contain any bytes.
  for (std::string* text : {&diagnostic.message, &diagnostic.hint}) *text = printable(*text);
  list_.push_back(std::move(diagnostic));
}

std::string Diagnostics::source_line(const Diagnostic& diagnostic) const {
  if (diagnostic.line < 1) return {};
  if (is_known(diagnostic.source, sources_.size()))
    return std::string(sources_[diagnostic.source]->line(diagnostic.line));
  for (const auto& source : sources_)
    if (source->name == diagnostic.file) return std::string(source->line(diagnostic.line));
  std::ifstream stream(diagnostic.file);
  std::string text;
  for (int i = 0; i < diagnostic.line; ++i)
    if (!std::getline(stream, text)) return {};
  if (text.ends_with('\r')) text.pop_back();
  return text;
}

std::string_view severity_name(Severity severity) {
  switch (severity) {
    case Severity::kError:
      return "error";
    case Severity::kWarning:
      return "warning";
    case Severity::kNote:
      break;
  }
  return "note";
}

namespace {

/// Terminal settings for a diagnostic: escape sequences, empty without color, and the width.
struct Look {
  bool colour;
  int width;

  const char* bold() const { return colour ? "\033[1m" : ""; }
  const char* green() const { return colour ? "\033[1;32m" : ""; }
  const char* end() const { return colour ? "\033[0m" : ""; }
  const char* tint(Severity severity) const {
    if (!colour) return "";
    if (severity == Severity::kNote) return "\033[1;36m";
    return severity == Severity::kError ? "\033[1;31m" : "\033[1;35m";
  }
};

/// A diagnostic with its source line and its hint.
std::string format(const Diagnostic& d, const std::string& line, const Look& look) {
  std::string place = d.file.empty() ? "conddp" : printable(d.file);
  if (d.line > 0) place += fmt::format(":{}:{}", d.line, std::max(d.column, 1));
  std::string text = wrap_text(
      fmt::format("{}{}:{} {}{}:{} {}", look.bold(), place, look.end(), look.tint(d.severity),
                  severity_name(d.severity), look.end(), d.message),
      look.width, 0, 4);
  if (!line.empty() && d.column > 0)
    text += excerpt(line, d.column, look.width, look.green(), look.end());
  if (!d.hint.empty())
    text +=
        wrap_text(fmt::format("{}hint:{} {}", look.bold(), look.end(), d.hint), look.width, 2, 8);
  return text;
}

}  // namespace

std::string format_diagnostics(const Diagnostics& diagnostics, bool colour, Severity least,
                               int limit, int width) {
  std::string text;
  int errors = 0;
  for (const Diagnostic& d : diagnostics.list()) {
    if (d.severity > least) continue;
    if (d.severity == Severity::kError && ++errors > limit) continue;
    text += format(d, diagnostics.source_line(d), {colour, width});
  }
  if (const int more = diagnostics.error_count() - limit; more > 0)
    text += fmt::format("conddp: error: {} more errors\n", more);
  return text;
}

}  // namespace conddp
