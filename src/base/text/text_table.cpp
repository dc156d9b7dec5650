#include "base/text/text_table.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace conddp {

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
