#include <stdexcept>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/data/data_table.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// Reads ascending numbers, or two lists of them.
bool read_points(const YamlReader& reader, TableSpec& table) {
  const auto items = reader.items("write ascending numbers, or two lists of them");
  if (!items) return false;
  if (!items->empty() && !items->front().is_sequence()) {
    const auto numbers = reader.numbers();
    if (numbers) table.points = {*numbers};
    return numbers.has_value();
  }
  constexpr std::size_t kMostArguments = 2;
  if (items->size() != kMostArguments)
    return reader.error("a table has the points of one argument or of two"), false;
  for (const YamlReader& item : *items) {
    const auto numbers = item.numbers();
    if (!numbers) return false;
    table.points.push_back(*numbers);
  }
  return true;
}

bool read_values(const YamlReader& reader, TableSpec& table) {
  if (table.points.size() == 1) {
    const auto numbers = reader.numbers(table.points[0].size(), "one per point");
    if (numbers) table.values = *numbers;
    return numbers.has_value();
  }
  const auto rows = reader.items("write a list for each point of the first argument");
  if (!rows) return false;
  if (rows->size() != table.points[0].size())
    return reader.error(fmt::format("the first argument has {} points, and there are {} rows",
                                    table.points[0].size(), rows->size())),
           false;
  for (const YamlReader& row : *rows) {
    const auto numbers =
        row.numbers(table.points[1].size(), "one per point of the second argument");
    if (!numbers) return false;
    table.values.insert(table.values.end(), numbers->begin(), numbers->end());
  }
  return true;
}

/// The numbers of a column; empty with an error if the column is missing or has an empty cell.
std::optional<std::vector<double>> column_of(const DataTable& data, const Name& column,
                                             Diagnostics& out) {
  const auto index = data.find(column.value);
  if (!index) {
    out.error(column.place, fmt::format("'{}' has no column '{}'", data.file, column.value),
              name_hint(column.value, data.columns, "its columns"));
    return std::nullopt;
  }
  std::vector<double> numbers;
  for (const auto& row : data.rows) {
    if (!row[*index]) {
      out.error(column.place,
                fmt::format("the column '{}' of '{}' has an empty cell", column.value, data.file));
      return std::nullopt;
    }
    numbers.push_back(*row[*index]);
  }
  return numbers;
}

/// Reads columns of a CSV file: the argument and the values.
bool read_columns(YamlMap& keys, const std::filesystem::path& folder, TableSpec& table) {
  const auto file = keys.require("file"), x = keys.require("x"), y = keys.require("y");
  if (!file || !x || !y) return false;
  const auto name = file->name(), argument = x->name(), value = y->name();
  if (!name || !argument || !value) return false;
  Diagnostics& out = keys.reader().diagnostics();
  const auto data = load_csv_columns(folder / name->value, name->place, out);
  if (!data) return false;
  const auto points = column_of(*data, *argument, out), values = column_of(*data, *value, out);
  if (!points || !values) return false;
  table.points = {*points};
  table.values = *values;
  return true;
}

bool read_numbers(YamlMap& keys, TableSpec& table) {
  const auto points = keys.require("points"), values = keys.require("values");
  return points && values && read_points(*points, table) && read_values(*values, table);
}

}  // namespace

std::vector<TableSpec> read_tables(const YamlReader& reader, const std::filesystem::path& folder) {
  std::vector<TableSpec> tables;
  const auto entries = reader.named_entries(
      "write '{drag: {points: [0, 1], values: [0, 2]}}' or '{drag: {file: "
      "drag.csv, x: speed, y: force}}'");
  if (!entries) return tables;
  for (const auto& [name, value] : *entries) {
    TableSpec table{.name = name};
    YamlMap keys(value);
    const bool from_file = value.is_map() && value.node().find("file") != nullptr;
    if (!(from_file ? read_columns(keys, folder, table) : read_numbers(keys, table))) continue;
    try {
      table.function =
          table.points.size() == 1
              ? std::make_shared<SplineTable>(table.points[0], table.values)
              : std::make_shared<SplineTable>(table.points[0], table.points[1], table.values);
      tables.push_back(std::move(table));
    } catch (const std::invalid_argument& e) {
      value.error(e.what());
    }
  }
  return tables;
}

}  // namespace conddp
