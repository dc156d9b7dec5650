#include <stdexcept>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/data/data_table.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

constexpr std::string_view kRowsSchema = R"({
  "type": "array",
  "items": {"type": ["number", "array"], "items": {"type": "number"}}
})";

/// Reads ascending numbers, or two lists of them.
void read_points(const YamlReader& reader, TableSpec& table) {
  const auto items = reader.items("write ascending numbers, or two lists of them");
  if (!items) return;
  if (!items->empty() && !items->front().is_sequence()) {
    if (const auto numbers = reader.numbers()) table.points = {*numbers};
    return;
  }
  constexpr std::size_t kMostArguments = 2;
  if (items->size() != kMostArguments)
    return reader.error("a table has the points of one argument or of two");
  const auto first = items->front().numbers();
  const auto second = first ? items->back().numbers() : std::nullopt;
  if (second) table.points = {*first, *second};
}

/// Reads a number for each point, or a row of them for each point of the first argument.
void read_values(const YamlReader& reader, TableSpec& table) {
  if (table.points.empty()) return;
  const std::size_t count = table.points[0].size();
  if (table.points.size() == 1) {
    table.values = reader.numbers(count, "one per point").value_or(std::vector<double>());
    return;
  }
  const auto rows = reader.items("write a list for each point of the first argument");
  if (!rows) return;
  if (rows->size() != count)
    return reader.error(fmt::format("the first argument has {} points, and there are {} rows",
                                    count, rows->size()));
  for (const YamlReader& row : *rows) {
    const auto numbers =
        row.numbers(table.points[1].size(), "one per point of the second argument");
    if (!numbers) return;
    table.values.insert(table.values.end(), numbers->begin(), numbers->end());
  }
}

OrderedJson expand_points(const TableSpec& table) {
  return table.points.size() == 1 ? OrderedJson(table.points[0]) : OrderedJson(table.points);
}

OrderedJson expand_values(const TableSpec& table) {
  if (table.points.size() == 1) return table.values;
  const std::size_t columns = table.points[1].size();
  OrderedJson rows = OrderedJson::array();
  for (auto row = table.values.begin(); row != table.values.end(); row += columns)
    rows.push_back(std::vector<double>(row, row + columns));
  return rows;
}

/// The numbers of a column; empty with an error if the column is missing or has an empty cell.
std::vector<double> column_of(const DataTable& data, const Name& column, Diagnostics& out) {
  std::vector<double> numbers;
  const auto index = data.find(column.value);
  if (!index)
    out.error(column.place, fmt::format("'{}' has no column '{}'", data.file, column.value),
              name_hint(column.value, data.columns, "its columns"));
  for (std::size_t i = 0; index && i < data.rows.size(); ++i) {
    const auto& cell = data.rows[i][*index];
    if (!cell) {
      out.error(column.place,
                fmt::format("the column '{}' of '{}' has an empty cell", column.value, data.file));
      break;
    }
    numbers.push_back(*cell);
  }
  return numbers;
}

/// Columns of a CSV file: the argument and the values.
struct TableColumns {
  Name file, x, y;
};

void load_columns(const YamlReader& reader, const TableColumns& columns, TableSpec& table) {
  Diagnostics& out = reader.diagnostics();
  const auto data = load_csv_columns(reader.folder() / columns.file.value, columns.file.place, out);
  if (!data) return;
  table.points = {column_of(*data, columns.x, out)};
  table.values = column_of(*data, columns.y, out);
}

void make_function(const YamlReader& reader, TableSpec& table) {
  try {
    table.function =
        table.points.size() == 1
            ? std::make_shared<SplineTable>(table.points[0], table.values)
            : std::make_shared<SplineTable>(table.points[0], table.points[1], table.values);
  } catch (const std::invalid_argument& e) {
    reader.error(e.what());
  }
}

}  // namespace

void describe(Keys& keys, TableSpec& table) {
  keys.about({.definition = "table",
              .title = "Tabulated function",
              .examples = R"([{"points": [0, 1, 2], "values": [0, 0.3, 0.5]},
                              {"file": "drag.csv", "x": "speed", "y": "force"}])",
              .rules = R"("oneOf": [{"required": ["points", "values"]},
                                    {"required": ["file", "x", "y"]}])"});
  YamlMap* map = keys.reading();
  const int errors = keys.errors();
  const bool from_file = map != nullptr && map->reader().has("file");
  const bool from_numbers = map != nullptr && !from_file;
  if (!from_file) {
    if (from_numbers) map->require("points"), map->require("values");
    keys({"points",
          "Ascending values of the argument, or a list of them for each of two arguments, in any "
          "unit"},
         CustomValue{[&](const YamlReader& reader) { read_points(reader, table); },
                     [&] { return expand_points(table); }, kRowsSchema});
    keys({"values",
          "One number for each point; of two arguments a list for each point of the first one"},
         CustomValue{[&](const YamlReader& reader) { read_values(reader, table); },
                     [&] { return expand_values(table); }, kRowsSchema});
  }
  TableColumns columns;
  if (!from_numbers) {
    keys({.name = "file",
          .says = "Instead of points and values: a CSV file with a header, relative to the problem "
                  "file",
          .required = from_file,
          .fallback = "none",
          .omitted = true},
         columns.file, NameForm{});
    keys({.name = "x",
          .says = "Of a file: the column of the argument, which ascends, in any unit",
          .required = from_file,
          .fallback = "none",
          .omitted = true},
         columns.x, NameForm{});
    keys({.name = "y",
          .says = "Of a file: the column of the values, in any unit",
          .required = from_file,
          .fallback = "none",
          .omitted = true},
         columns.y, NameForm{});
  }
  if (map == nullptr || keys.errors() > errors) return;
  if (from_file) load_columns(map->reader(), columns, table);
  if (keys.errors() == errors) make_function(map->reader(), table);
}

TablesForm::TablesForm()
    : EntriesForm{.name = &TableSpec::name,
                  .hint =
                      "write '{drag: {points: [0, 1], values: [0, 2]}}' or '{drag: {file: "
                      "drag.csv, x: speed, y: force}}'"} {}

OrderedJson TablesForm::schema(const std::vector<TableSpec>& tables,
                               SchemaDefinitions& definitions) const {
  return defined(definitions, "tables", [&] {
    OrderedJson schema = {{"title", "Tabulated functions"},
                          {"description",
                           "Functions by name: natural cubic splines through tabulated values, "
                           "linear beyond the ends"}};
    schema.update(EntriesForm::schema(tables, definitions));
    return schema;
  });
}

}  // namespace conddp
