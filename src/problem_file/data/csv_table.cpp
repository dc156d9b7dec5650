#include <algorithm>
#include <unordered_set>

#include <fmt/format.h>

#include "base/text/csv_line.hpp"
#include "base/text/spelling.hpp"
#include "base/text/strict_number.hpp"
#include "problem_file/data/data_table.hpp"

namespace conddp {
namespace {

/// Removes a unit: "q/hip [rad]" is the column q/hip.
std::string_view without_unit(std::string_view name) {
  const std::size_t bracket = name.rfind(" [");
  return name.ends_with(']') && bracket != std::string_view::npos && bracket > 0
             ? trimmed_csv(name.substr(0, bracket))
             : name;
}

class CsvReader {
 public:
  CsvReader(const std::string& text, const std::string& name, bool over_time, Diagnostics& out)
      : rest_(text), over_time_(over_time), out_(out), source_(out.add_source(name, text)) {
    table_.file = name;
  }

  std::optional<DataTable> read() {
    if (!read_header()) return std::nullopt;
    while (next_line())
      if (!trimmed_csv(line_).empty() && !read_row()) return std::nullopt;
    if (table_.rows.empty()) return fail(0, "there is no row under the header"), std::nullopt;
    return std::move(table_);
  }

 private:
  bool next_line() {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++number_;
    return true;
  }
  bool fail(int byte, std::string message, std::string hint = {}) {
    const int line = std::max(number_, 1);
    out_.error({{source_, line, out_.character_column(source_, line, byte)}, {}},
               std::move(message), std::move(hint));
    return false;
  }
  bool read_header() {
    if (!next_line()) return fail(0, "there is nothing in the file");
    for (const CsvCell& cell : split_csv_line(line_))
      if (!add_column(cell)) return false;
    if (over_time_ && !time_) return fail(0, "no column holds the time", "name it 't'; it is in s");
    find_data();
    return true;
  }
  bool add_column(const CsvCell& cell) {
    const std::string name(without_unit(cell.text));
    if (name.empty()) return fail(cell.byte, "a column has no name");
    if (parse_number(name).value)
      return fail(cell.byte, "the first line must name the columns", "t,q/joint,...");
    if (!names_.insert(name).second)
      return fail(cell.byte, fmt::format("two columns have the name '{}'", name));
    if (over_time_ && (name == "t" || name == "time")) {
      if (time_) return fail(cell.byte, "two columns hold the time");
      time_ = header_.size();
    }
    header_.push_back(name);
    return true;
  }
  /// Excludes columns of words, such as the phase.
  void find_data() {
    const std::string_view first = rest_.substr(0, rest_.find('\n'));
    const std::vector<CsvCell> cells = split_csv_line(first);
    for (std::size_t i = 0; i < header_.size(); ++i) {
      const bool word = i < cells.size() && header_[i] == "phase" && !cells[i].text.empty();
      is_data_.push_back(time_ != i && !word);
      if (is_data_[i]) table_.columns.push_back(header_[i]);
    }
  }
  bool read_row() {
    const std::vector<CsvCell> cells = split_csv_line(line_);
    if (cells.size() != header_.size())
      return fail(0, fmt::format("this line has {} cells, the header has {}", cells.size(),
                                 header_.size()));
    table_.rows.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i)
      if ((time_ == i || is_data_[i]) && !read_cell(cells[i], i)) return false;
    return true;
  }
  bool read_cell(const CsvCell& cell, std::size_t column) {
    const bool is_time = time_ == column;
    if (cell.text.empty() && !is_time) {
      table_.rows.back().emplace_back();
      return true;
    }
    const ParsedNumber number = parse_number(cell.text);
    if (!number.value)
      return fail(cell.byte, fmt::format("in the column '{}': {}", header_[column], number.defect));
    if (!is_time) {
      table_.rows.back().push_back(number.value);
      return true;
    }
    if (!table_.times.empty() && *number.value <= table_.times.back())
      return fail(cell.byte, "the time does not increase");
    table_.times.push_back(*number.value);
    return true;
  }

  std::string_view rest_;
  bool over_time_;
  Diagnostics& out_;
  int source_;
  DataTable table_;
  std::string_view line_;
  int number_ = 0;
  std::vector<std::string> header_;
  std::unordered_set<std::string> names_;  ///< names in the header
  std::vector<bool> is_data_;
  std::optional<std::size_t> time_;
};

}  // namespace

std::optional<DataTable> parse_csv(const std::string& text, const std::string& name,
                                   Diagnostics& out) {
  return CsvReader(text, name, true, out).read();
}

std::optional<DataTable> parse_csv_columns(const std::string& text, const std::string& name,
                                           Diagnostics& out) {
  return CsvReader(text, name, false, out).read();
}

}  // namespace conddp
