#include "base/text/text_layout.hpp"

#include <algorithm>

#include <fmt/format.h>

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

bool TextTable::used(std::size_t column) const {
  return std::any_of(rows.begin(), rows.end(),
                     [&](const auto& row) { return !row[column].empty(); });
}

std::string TextTable::text(int indent) const {
  std::vector<std::string> lines(rows.size() + 1, std::string(indent, ' '));
  bool first = true;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (!used(c)) continue;
    std::size_t width = columns[c].title.size();
    for (const auto& row : rows) width = std::max(width, row[c].size());
    for (std::size_t r = 0; r < lines.size(); ++r) {
      const std::string& cell = r == 0 ? columns[c].title : rows[r - 1][c];
      if (!first) lines[r] += "  ";
      lines[r] += columns[c].right ? fmt::format("{:>{}}", cell, width)
                                   : fmt::format("{:<{}}", cell, width);
    }
    first = false;
  }
  std::string text;
  for (std::string& line : lines) {
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

std::string TextTable::markdown() const {
  std::string heading = "|", rule = "|", body;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (!used(c)) continue;
    heading += fmt::format(" {} |", columns[c].title);
    rule += columns[c].right ? "---:|" : "---|";
  }
  for (const auto& row : rows) {
    body += '|';
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (used(c)) body += fmt::format(" {} |", row[c]);
    body += '\n';
  }
  return heading + '\n' + rule + '\n' + body;
}

}  // namespace conddp
