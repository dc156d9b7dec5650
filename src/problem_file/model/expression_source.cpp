#include "problem_file/model/expression_source.hpp"

#include <algorithm>

#include "base/text/utf8.hpp"

namespace conddp {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// The text of a scalar, or of a list of such texts; empty if it contains anything else.
std::optional<std::string> text_of(const YamlNode& node) {
  if (node.kind == YamlNode::Kind::kScalar) return node.text;
  if (node.kind != YamlNode::Kind::kSequence) return std::nullopt;
  std::string text = "[";
  for (const YamlNode& item : node.items) {
    const auto part = text_of(item);
    if (!part) return std::nullopt;
    text += (text.size() > 1 ? ", " : "") + *part;
  }
  return text + "]";
}

/// Steps through a source from a mark on, skipping blanks.
class SourceWalk {
 public:
  SourceWalk(const Diagnostics& sources, const Mark& mark) : sources_(sources), mark_(mark) {
    line_ = sources_.line(mark_.source, mark_.line);
    int character = 0;
    while (at_ < line_.size() && !(starts_character(line_[at_]) && ++character == mark_.column))
      ++at_;
  }

  /// Skips the opening quote or block header of a scalar.
  void open_quotes() {
    if (at_ == line_.size()) return;
    const char c = line_[at_];
    if (c == '\'' || c == '"') ++at_;
    if (c == '|' || c == '>') at_ = line_.size();
  }
  /// Returns the next nonblank character and moves past it; 0 at the end.
  char next() {
    constexpr int kMostEmptyLines = 1000;
    for (int empty = 0; empty < kMostEmptyLines; ++empty) {
      while (at_ < line_.size() && is_blank(line_[at_])) ++at_;
      if (at_ < line_.size()) {
        last_ = {mark_.source, mark_.line,
                 sources_.character_column(mark_.source, mark_.line, at())};
        return line_[at_++];
      }
      line_ = sources_.line(mark_.source, ++mark_.line);
      at_ = 0;
    }
    return 0;
  }
  /// Position of the last character, and the position after it.
  Mark last() const { return last_; }
  Mark behind_last() const { return {last_.source, last_.line, last_.column + 1}; }

 private:
  int at() const { return static_cast<int>(at_); }

  const Diagnostics& sources_;
  Mark mark_;
  std::string_view line_;
  std::size_t at_ = 0;
  Mark last_;
};

/// Index of the first nonblank character from a position on; the text size if only blanks follow.
std::size_t next_character(std::string_view text, std::size_t at) {
  while (at < text.size() && is_blank(text[at])) ++at;
  return at;
}

}  // namespace

std::optional<ExpressionText> read_expression(const YamlReader& reader) {
  auto text = text_of(reader.node());
  if (text) return ExpressionText{*std::move(text), reader.place(), reader.node().quoted};
  reader.expected("an expression", reader.is_null()
                                       ? "inside { } of YAML an expression with a comma needs "
                                         "quotes"
                                       : "");
  return std::nullopt;
}

Place place_in_expression(const ExpressionText& expression, int offset,
                          const Diagnostics& sources) {
  const Place& whole = expression.place;
  const std::string& text = expression.text;
  if (whole.mark.source < 0 || whole.mark.line <= 0) return whole;
  SourceWalk walk(sources, whole.mark);
  if (expression.quoted) walk.open_quotes();
  const std::size_t first = next_character(text, 0);
  if (first == text.size()) return whole;
  const std::size_t wanted = static_cast<std::size_t>(std::max(offset, 0));
  for (std::size_t i = first; i < text.size(); i = next_character(text, i + 1)) {
    if (i > first && i > wanted) break;
    // An escape in the source, or another difference between source and text.
    if (walk.next() != text[i]) return whole;
    if (i >= wanted) return {walk.last(), whole.path};
  }
  return {walk.behind_last(), whole.path};
}

namespace {

/// True if a message concerns the end of an unquoted text that precedes a comma in the source. YAML
/// begins the next entry there.
bool is_cut_at_comma(const ExpressionText& expression, int offset, const Diagnostics& sources) {
  const std::string& text = expression.text;
  if (expression.quoted || offset < static_cast<int>(text.size())) return false;
  const Mark& mark = expression.place.mark;
  if (mark.source < 0 || mark.line <= 0) return false;
  SourceWalk walk(sources, mark);
  for (const char c : text)
    if (!is_blank(c) && walk.next() != c) return false;
  return walk.next() == ',';
}

}  // namespace

void report_expression(const ExpressionText& expression, const ExpressionMessage& message,
                       Severity severity, Diagnostics& out) {
  const Place place = place_in_expression(expression, message.offset, out);
  std::string hint = message.hint;
  if (hint.empty() && is_cut_at_comma(expression, message.offset, out))
    hint = "inside { } or [ ] of YAML an expression with a comma needs quotes";
  if (severity == Severity::kError)
    out.error(place, message.message, std::move(hint));
  else
    out.warning(place, message.message, std::move(hint));
}

}  // namespace conddp
