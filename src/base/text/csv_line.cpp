#include "base/text/csv_line.hpp"

#include <algorithm>
#include <optional>

namespace conddp {
namespace {

/// A quoted text, and the end of its cell: at a comma or the end of the line.
struct Quoted {
  std::string text;
  std::size_t end;
};

/// The text whose opening quote is at `start`; nothing if the quote is not closed before the cell
/// ends.
std::optional<Quoted> read_quoted(std::string_view line, std::size_t start) {
  std::string text;
  for (std::size_t at = start + 1; at < line.size(); ++at) {
    if (line[at] != '"') {
      text += line[at];
      continue;
    }
    if (line.substr(at + 1).starts_with('"')) {
      text += line[++at];
      continue;
    }
    const std::size_t end = std::min(line.find(',', at), line.size());
    if (!trimmed_csv(line.substr(at + 1, end - at - 1)).empty()) return std::nullopt;
    return Quoted{std::move(text), end};
  }
  return std::nullopt;
}

}  // namespace

std::string_view trimmed_csv(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return text.substr(0, text.find_last_not_of(" \t\r") + 1);
}

std::vector<CsvCell> split_csv_line(std::string_view line) {
  std::vector<CsvCell> cells;
  for (std::size_t start = 0;;) {
    std::size_t end = std::min(line.find(',', start), line.size());
    const std::string_view text = trimmed_csv(line.substr(start, end - start));
    const std::size_t begin =
        text.empty() ? start : static_cast<std::size_t>(text.data() - line.data());
    auto quoted = text.starts_with('"') ? read_quoted(line, begin) : std::nullopt;
    cells.push_back(
        {quoted ? std::move(quoted->text) : std::string(text), static_cast<int>(begin)});
    if (quoted) end = quoted->end;
    if (end == line.size()) return cells;
    start = end + 1;
  }
}

bool begins_formula(std::string_view text) {
  return !text.empty() && std::string_view("=+-@").find(text[0]) != std::string_view::npos;
}

}  // namespace conddp
