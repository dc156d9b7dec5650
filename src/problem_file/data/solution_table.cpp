#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/json_document.hpp"
#include "base/solution_members.hpp"
#include "base/source_text.hpp"
#include "problem_file/data/data_table.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

std::vector<std::string> read_names(const Json& array, const char* what) {
  std::vector<std::string> names;
  if (!array.is_array()) throw MalformedSolution{fmt::format("'{}' is not a list", what)};
  for (const Json& name : array) {
    if (!name.is_string())
      throw MalformedSolution{fmt::format("'{}' has an entry that is not a name", what)};
    if (std::find(names.begin(), names.end(), name.get_ref<const std::string&>()) != names.end())
      throw MalformedSolution{
          fmt::format("'{}' stands twice in {}", name.get<std::string>(), what)};
    names.push_back(name);
  }
  return names;
}

/// Appends one row of numbers (null: an empty cell) to the table's row.
void append_row(const Json& array, std::size_t count, const std::string& what,
                std::vector<std::optional<double>>& row) {
  if (!array.is_array() || array.size() != count)
    throw MalformedSolution{fmt::format("{} should have {} numbers", what, count)};
  for (const Json& value : array) {
    if (value.is_null())
      row.emplace_back();
    else if (value.is_number() && std::isfinite(value.get<double>()))
      row.push_back(value.get<double>());
    else
      throw MalformedSolution{fmt::format("{} has an entry that is not a finite number", what)};
  }
}

DataTable read_trajectory(const Json& solution) {
  const Json& trajectory = solution_member(solution, "trajectory");
  const Json& columns = solution_member(trajectory, "columns");
  DataTable table;
  const auto x_names = read_names(solution_member(columns, "x"), "trajectory.columns.x");
  const auto u_names = read_names(solution_member(columns, "u"), "trajectory.columns.u");
  table.columns = x_names;
  table.state_columns = x_names.size();
  table.columns.insert(table.columns.end(), u_names.begin(), u_names.end());
  const Json& t = solution_member(trajectory, "t");
  const Json& x = solution_member(trajectory, "x");
  const Json& u = solution_member(trajectory, "u");
  if (!t.is_array() || !x.is_array() || !u.is_array() || t.empty() || x.size() != t.size() ||
      u.size() + 1 != t.size())
    throw MalformedSolution{"the lists t, x and u of its trajectory do not fit together"};
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (!t[k].is_number() || (k > 0 && t[k].get<double>() < table.times.back()))
      throw MalformedSolution{"its times do not increase"};
    if (k > 0 && t[k].get<double>() == table.times.back()) {
      // An impulse takes no time: what holds after it stands for the moment.
      table.times.pop_back();
      table.rows.pop_back();
    }
    table.times.push_back(t[k]);
    auto& row = table.rows.emplace_back();
    append_row(x[k], x_names.size(), fmt::format("trajectory.x[{}]", k), row);
    // Where no time passes there is no control, or a choice of the state.
    const bool passes = k + 1 < t.size() && t[k] != t[k + 1];
    const bool controlled = k < u.size() && passes && !(u[k].is_array() && u[k].empty());
    if (controlled)
      append_row(u[k], u_names.size(), fmt::format("trajectory.u[{}]", k), row);
    else
      row.resize(table.columns.size());
  }
  return table;
}

}  // namespace

std::optional<DataTable> parse_solution(const std::string& text, const std::string& name,
                                        Diagnostics& out) {
  constexpr std::string_view kKeys[] = {"trajectory"};
  const auto solution = parse_document(text, name, kSolutionDocument, kKeys, out);
  if (!solution) return std::nullopt;
  try {
    DataTable table = read_trajectory(*solution);
    table.file = name;
    return table;
  } catch (const MalformedSolution& e) {
    out.add({.file = name, .message = "the solution cannot be used: " + std::string(e.what())});
  }
  return std::nullopt;
}

std::optional<std::size_t> DataTable::find(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

namespace {

std::optional<std::string> load_text(const std::filesystem::path& file, const Place& place,
                                     Diagnostics& out) {
  InputFile input{file.string(), {}};
  auto text = read_text(file, kMaxDataBytes, place, input.sha256, out);
  if (text) out.add_data_file(std::move(input));
  return text;
}

}  // namespace

std::optional<DataTable> load_csv_columns(const std::filesystem::path& file, const Place& place,
                                          Diagnostics& out) {
  const auto text = load_text(file, place, out);
  return text ? parse_csv_columns(*text, file.string(), out) : std::nullopt;
}

std::optional<DataTable> load_data_table(const std::filesystem::path& file, const Place& place,
                                         Diagnostics& out) {
  const auto text = load_text(file, place, out);
  if (!text) return std::nullopt;
  if (file.extension() == ".json") return parse_solution(*text, file.string(), out);
  return parse_csv(*text, file.string(), out);
}

}  // namespace conddp
