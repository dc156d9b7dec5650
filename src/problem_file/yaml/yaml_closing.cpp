#include "problem_file/yaml/yaml_closing.hpp"

namespace conddp {

namespace {

bool is_one_of(char c, std::string_view characters) {
  return characters.find(c) != characters.npos;
}

bool is_quote(char c) { return is_one_of(c, "\"'"); }

/// True for two consecutive single quotes, which escape one inside a single-quoted text.
bool is_doubled(std::string_view text, std::size_t at) {
  return text[at] == '\'' && at + 1 < text.size() && text[at + 1] == '\'';
}

bool begins_comment(std::string_view text, std::size_t at) {
  return text[at] == '#' && at > 0 && is_one_of(text[at - 1], " \n");
}

}  // namespace

std::size_t quote_end(std::string_view text, std::size_t at) {
  if (at >= text.size() || !is_quote(text[at])) return at;
  const char quote = text[at];
  for (std::size_t i = at + 1; i < text.size(); ++i) {
    const bool escape = text[i] == '\\' && quote == '"';
    if (text[i] == quote && !is_doubled(text, i)) return i;
    if (escape || text[i] == quote) ++i;
  }
  return text.npos;
}

bool bracket_closes(std::string_view text, std::size_t at) {
  std::size_t open = 0;
  for (std::size_t i = at; i < text.size(); ++i) {
    const char c = text[i];
    if (is_one_of(c, "[{")) ++open;
    if (is_one_of(c, "]}") && --open == 0) return true;
    if (begins_comment(text, i))
      i = text.find('\n', i);
    else if (is_quote(c))
      i = quote_end(text, i);
    if (i == text.npos) return false;
  }
  return false;
}

}  // namespace conddp
