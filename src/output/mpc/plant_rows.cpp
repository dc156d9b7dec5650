#include "output/mpc/plant_rows.hpp"

#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "base/json/json_document.hpp"
#include "base/text/csv_line.hpp"
#include "base/text/strict_number.hpp"
#include "output/mpc/loop_files.hpp"

namespace conddp {
namespace {

/// Removes and returns the first line of a text.
std::string_view next_line(std::string_view& rest) {
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return line;
}

double number_of(const CsvCell& cell, int line) {
  if (cell.text.empty()) return std::numeric_limits<double>::quiet_NaN();
  const ParsedNumber number = parse_number(cell.text);
  if (!number.value) throw MalformedSolution{fmt::format("line {}: {}", line, number.defect)};
  return *number.value;
}

/// Numbers of `count` cells starting at `from`.
std::vector<double> numbers_of(const std::vector<CsvCell>& cells, std::size_t from,
                               std::size_t count, int line) {
  std::vector<double> numbers;
  for (std::size_t i = from; i < from + count; ++i) numbers.push_back(number_of(cells[i], line));
  return numbers;
}

/// Only the last state of a loop may be non-finite; all other states need numbers.
void check_states(const PlantRows& rows) {
  constexpr int kFirstLine = 2;
  for (std::size_t row = 0; row + 1 < rows.x.size(); ++row)
    for (const double number : rows.x[row])
      if (std::isnan(number))
        throw MalformedSolution{
            fmt::format("line {}: a cell of the state is empty", kFirstLine + row)};
}

}  // namespace

PlantRows read_plant_rows(const std::string& text, const LoopTask& task) {
  constexpr std::size_t kBefore = 2;  // columns of time and phase
  const std::size_t nx = task.built.state_columns.size(), nu = task.built.control_columns.size();
  const std::string header = closed_loop_header(task);
  const std::size_t columns = split_csv_line(header).size();
  std::string_view rest = text;
  if (next_line(rest) != header)
    throw MalformedSolution{"line 1: the columns are not those of the problem"};
  PlantRows rows;
  for (int line = 2; !rest.empty(); ++line) {
    const std::vector<CsvCell> cells = split_csv_line(next_line(rest));
    if (cells.size() != columns)
      throw MalformedSolution{
          fmt::format("line {}: {} cells in place of {}", line, cells.size(), columns)};
    rows.times.push_back(number_of(cells[0], line));
    if (rows.times.size() > 1 && !(rows.times.back() > rows.times[rows.times.size() - 2]))
      throw MalformedSolution{fmt::format("line {}: the time does not increase", line)};
    rows.x.push_back(numbers_of(cells, kBefore, nx, line));
    rows.u.push_back(numbers_of(cells, kBefore + nx, nu, line));
  }
  if (rows.times.empty()) throw MalformedSolution{"there is no row"};
  check_states(rows);
  return rows;
}

}  // namespace conddp
