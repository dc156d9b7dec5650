#include "output/solution/csv_cells.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include <fmt/compile.h>
#include <fmt/format.h>

#include "base/text/csv_line.hpp"
#include "problem_file/data/data_table.hpp"

namespace conddp {

void append_cell(double value, std::string& text) {
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(text), FMT_COMPILE("{}"), value);
}

std::string csv_cell(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return c == ',' || c == '"' || static_cast<unsigned char>(c) < 0x20; }, '_');
  return begins_formula(text) ? '_' + text : text;
}

std::string with_unit(std::string name, std::string_view unit) {
  if (unit.empty() || unit == "1") return name;
  return fmt::format("{} [{}]", name, unit);
}

std::string column_headers(const BuiltProblem& built, const TableColumns& columns) {
  std::string text;
  std::set<std::string> used;
  for (const int i : columns.states) {
    const Column& column = built.state_columns[i];
    used.insert(column.name);
    const std::string_view prefix = is_time_or_phase(column.name) ? kStatePrefix : "";
    text += ',' + with_unit(csv_cell(std::string(prefix) + column.name), column.unit);
  }
  for (std::size_t i = columns.first_control; i < built.control_columns.size(); ++i) {
    const Column& column = built.control_columns[i];
    const bool taken = used.contains(column.name) || is_time_or_phase(column.name);
    const std::string_view prefix = taken ? kControlPrefix : "";
    text += ',' + with_unit(csv_cell(std::string(prefix) + column.name), column.unit);
  }
  return text;
}

}  // namespace conddp
