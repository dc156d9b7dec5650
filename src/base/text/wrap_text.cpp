#include "base/text/wrap_text.hpp"

#include <algorithm>

#include "base/text/utf8.hpp"

namespace conddp {

int shown_width(std::string_view text) {
  int width = 0;
  while (!text.empty()) {
    const std::size_t escape = text.find("\033[");
    width += count_characters(text.substr(0, escape));
    if (escape == text.npos) break;
    const std::size_t end = text.find('m', escape);
    text = end == text.npos ? std::string_view() : text.substr(end + 1);
  }
  return width;
}

namespace {

/// Takes as many words as fit after a margin, but at least one.
std::string take_line(std::string_view& rest, int width, int margin) {
  if (rest.empty()) return {};
  std::string line(margin, ' ');
  int used = margin;
  for (bool first = true; !rest.empty(); first = false) {
    const std::size_t word_end =
        std::min(rest.find(' ', first ? rest.find_first_not_of(' ') : 1), rest.size());
    const std::string_view word = rest.substr(0, word_end);
    used += shown_width(word);
    if (width > 0 && !first && used > width) break;
    line += word;
    rest.remove_prefix(word_end);
  }
  return line;
}

}  // namespace

std::string wrap_text(std::string_view text, int width, int first, int indent) {
  std::string lines;
  int margin = first;
  while (true) {
    const std::size_t line_end = text.find('\n');
    std::string_view rest = text.substr(0, line_end);
    do {
      lines += take_line(rest, width, margin) + '\n';
      margin = indent;
      rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
    } while (!rest.empty());
    if (line_end == text.npos) return lines;
    text.remove_prefix(line_end + 1);
  }
}

}  // namespace conddp
