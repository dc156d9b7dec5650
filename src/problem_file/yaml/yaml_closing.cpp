#include "problem_file/yaml/yaml_closing.hpp"

namespace conddp {

std::size_t quote_end(std::string_view text, std::size_t at) {
  if (at >= text.size() || (text[at] != '"' && text[at] != '\'')) return at;
  const char quote = text[at];
  for (std::size_t i = at + 1; i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"') {
      ++i;
    } else if (text[i] == quote) {
      const bool doubled = quote == '\'' && i + 1 < text.size() && text[i + 1] == quote;
      if (!doubled) return i;
      ++i;
    }
  }
  return text.npos;
}

bool bracket_closes(std::string_view text, std::size_t at) {
  std::size_t open = 0;
  for (std::size_t i = at; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '[' || c == '{') ++open;
    if ((c == ']' || c == '}') && --open == 0) return true;
    if (c == '#' && i > 0 && (text[i - 1] == ' ' || text[i - 1] == '\n'))
      i = text.find('\n', i);
    else if (c == '"' || c == '\'')
      i = quote_end(text, i);
    if (i == text.npos) return false;
  }
  return false;
}

}  // namespace conddp
