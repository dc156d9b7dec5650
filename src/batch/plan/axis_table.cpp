#include "batch/plan/axis_table.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "base/files/text_file.hpp"
#include "base/text/csv_line.hpp"
#include "base/text/spelling.hpp"
#include "base/text/strict_number.hpp"
#include "problem_file/yaml/yaml_source.hpp"

namespace conddp {
namespace {

/// Reads the lines of a table.
class TableReader {
 public:
  TableReader(const std::string& text, std::string name, Diagnostics& out)
      : text_(text), out_(out), source_(out.add_source(std::move(name), text)) {}

  std::vector<std::vector<YamlNode>> read(const std::vector<Name>& columns) {
    const std::vector<CsvCell> header = next_line();
    for (const CsvCell& cell : header) names_.push_back(cell.text);
    if (names_ == std::vector<std::string>{""}) {
      fail(0, "the table is empty: the names of its columns are expected in its first line");
      return {};
    }
    if (!choose(columns, header)) return {};
    std::vector<std::vector<YamlNode>> rows;
    while (start_ < text_.size()) {
      const std::vector<CsvCell> cells = next_line();
      if (cells.size() == 1 && cells[0].text.empty()) continue;
      auto row = read_row(cells);
      if (!row) return {};
      rows.push_back(*std::move(row));
    }
    if (rows.empty()) fail(0, "there is no row under the header");
    return rows;
  }

 private:
  /// Finds the requested columns; reports missing and duplicate ones.
  bool choose(const std::vector<Name>& columns, const std::vector<CsvCell>& header) {
    for (const Name& column : columns) {
      const auto found = std::find(names_.begin(), names_.end(), column.value);
      if (found == names_.end()) {
        out_.error(column.place, fmt::format("the table has no column '{}'", column.value),
                   name_hint(column.value, names_, "columns"), names_);
        return false;
      }
      if (const auto again = std::find(found + 1, names_.end(), column.value);
          again != names_.end()) {
        fail(header[static_cast<std::size_t>(again - names_.begin())].byte,
             fmt::format("two columns have the name '{}'", column.value));
        return false;
      }
      chosen_.push_back(static_cast<std::size_t>(found - names_.begin()));
    }
    return true;
  }

  /// The chosen cells of a line. Nothing, with an error, if one of them is missing.
  std::optional<std::vector<YamlNode>> read_row(const std::vector<CsvCell>& cells) {
    if (cells.size() != names_.size()) {
      fail(0,
           fmt::format("this line has {} cells, the header has {}", cells.size(), names_.size()));
      return std::nullopt;
    }
    std::vector<YamlNode> row;
    for (const std::size_t c : chosen_) {
      if (cells[c].text.empty()) {
        fail(cells[c].byte, fmt::format("the cell of the column '{}' is empty", names_[c]));
        return std::nullopt;
      }
      auto value = read_cell(cells[c], c);
      if (!value) return std::nullopt;
      row.push_back(*std::move(value));
    }
    return row;
  }

  /// A number, list or mapping; otherwise a text. Nothing, with an error, if a list is invalid.
  std::optional<YamlNode> read_cell(const CsvCell& cell, std::size_t column) {
    if (!cell.text.starts_with('[') && !cell.text.starts_with('{'))
      return YamlNode{.kind = YamlNode::Kind::kScalar,
                      .mark = mark(cell.byte),
                      .text = cell.text,
                      .quoted = !is_plain(cell.text)};
    Diagnostics own;
    auto list = parse_yaml(cell.text, own.add_source({}, cell.text), own);
    if (list)
      move_to(mark(cell.byte), *list);
    else
      fail(cell.byte,
           fmt::format("in the column '{}': {}", names_[column], own.list().front().message));
    return list;
  }

  /// True if YAML reads a text unchanged without quotes: a number or a word.
  static bool is_plain(const std::string& text) {
    constexpr std::string_view kLetters =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-";
    return parse_number(text).value || (text != "null" && text[0] != '-' &&
                                        text.find_first_not_of(kLetters) == std::string::npos);
  }

  /// Assigns the same place to all parts of a value, because a cell's quotes may hide the position
  /// of each part.
  static void move_to(const Mark& mark, YamlNode& node) {
    node.mark = mark;
    for (YamlNode& item : node.items) move_to(mark, item);
    for (YamlNode::Entry& entry : node.entries) {
      entry.mark = mark;
      move_to(mark, entry.value);
    }
  }

  std::vector<CsvCell> next_line() {
    const std::size_t end = std::min(text_.find('\n', start_), text_.size());
    const std::string_view line = std::string_view(text_).substr(start_, end - start_);
    start_ = end + 1;
    ++number_;
    return split_csv_line(line);
  }
  Mark mark(int byte) const {
    return {source_, number_, out_.character_column(source_, number_, byte)};
  }
  void fail(int byte, std::string message) { out_.error({mark(byte), {}}, std::move(message)); }

  const std::string& text_;
  Diagnostics& out_;
  const int source_;
  std::size_t start_ = 0;
  int number_ = 0;
  std::vector<std::string> names_;   ///< from the header
  std::vector<std::size_t> chosen_;  ///< indices of columns
};

}  // namespace

std::vector<std::vector<YamlNode>> read_axis_table(const std::filesystem::path& file,
                                                   const Place& place,
                                                   const std::vector<Name>& columns,
                                                   Diagnostics& out) {
  std::string hash;
  const auto text = read_text(file, kMaxDataBytes, place, hash, out);
  if (!text) return {};
  return TableReader(*text, file.string(), out).read(columns);
}

}  // namespace conddp
