#include "base/text/csv_line.hpp"

#include <algorithm>

namespace conddp {

std::string_view trimmed_csv(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return text.substr(0, text.find_last_not_of(" \t\r") + 1);
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
