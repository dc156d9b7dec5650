#include "base/csv_line.hpp"

#include <algorithm>

namespace conddp {

std::string_view trimmed_csv(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  return text;
}

std::vector<CsvCell> split_csv_line(std::string_view line) {
  std::vector<CsvCell> cells;
  for (std::size_t start = 0;;) {
    const std::size_t comma = std::min(line.find(',', start), line.size());
    const std::string_view text = trimmed_csv(line.substr(start, comma - start));
    cells.push_back({text, static_cast<int>(text.empty() ? start : text.data() - line.data())});
    if (comma == line.size()) return cells;
    start = comma + 1;
  }
}

}  // namespace conddp
