#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/files/text_file.hpp"
#include "base/json/json_document.hpp"
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

/// The rows of a solution's trajectory.
class TrajectoryReader {
 public:
  explicit TrajectoryReader(const Json& trajectory)
      : t_(solution_member(trajectory, "t")),
        x_(solution_member(trajectory, "x")),
        u_(solution_member(trajectory, "u")) {
    if (!are_lists() || t_.empty() || x_.size() != t_.size() || u_.size() + 1 != t_.size())
      throw MalformedSolution{"the lists t, x and u of its trajectory do not fit together"};
  }

  /// Appends all rows to a table whose columns are set.
  void read(std::size_t nx, std::size_t nu, DataTable& table) const {
    for (std::size_t k = 0; k < t_.size(); ++k) {
      append_time(k, table.times);
      auto& row = table.rows.emplace_back();
      append_row(x_[k], nx, fmt::format("trajectory.x[{}]", k), row);
      if (has_control(k))
        append_row(u_[k], nu, fmt::format("trajectory.u[{}]", k), row);
      else
        row.resize(nx + nu);
    }
  }

 private:
  bool are_lists() const { return t_.is_array() && x_.is_array() && u_.is_array(); }

  /// An impulse takes no time: the rows before and after it have equal times.
  void append_time(std::size_t k, std::vector<double>& times) const {
    if (!t_[k].is_number() || (k > 0 && t_[k].get<double>() < times.back()))
      throw MalformedSolution{"its times do not increase"};
    times.push_back(t_[k]);
  }

  /// Knots without time have no control, or a choice of the state in its place.
  bool has_control(std::size_t k) const {
    const bool passes = k + 1 < t_.size() && t_[k] != t_[k + 1];
    return k < u_.size() && passes && !(u_[k].is_array() && u_[k].empty());
  }

  const Json &t_, &x_, &u_;
};

/// Consecutive phases from the first node to the last; empty without a list.
std::vector<FormerPhase> read_phases(const Json& trajectory, std::size_t nodes) {
  std::vector<FormerPhase> phases;
  const auto list = trajectory.find("phases");
  if (list == trajectory.end()) return phases;
  if (!list->is_array()) throw MalformedSolution{"'trajectory.phases' is not a list"};
  std::size_t first = 0;
  for (const Json& phase : *list) {
    const Json& name = solution_member(phase, "name");
    const Json& knots = solution_member(phase, "knots");
    if (!name.is_string() || !knots.is_number_unsigned() ||
        knots.get<std::size_t>() >= nodes - first)
      throw MalformedSolution{"the phases of its trajectory do not fit its nodes"};
    phases.push_back({name, first, first + knots.get<std::size_t>()});
    first = phases.back().last;
  }
  if (first + 1 != nodes)
    throw MalformedSolution{"the phases of its trajectory do not fit its nodes"};
  return phases;
}

/// Number of linear controls at the end of a solution's states.
std::size_t linear_controls(const std::vector<std::string>& u_names) {
  return std::ranges::count_if(
      u_names, [](const std::string& name) { return name.starts_with(kEndOfKnot); });
}

DataTable read_trajectory(const Json& solution) {
  const Json& trajectory = solution_member(solution, "trajectory");
  const Json& columns = solution_member(trajectory, "columns");
  const auto x_names = read_names(solution_member(columns, "x"), "trajectory.columns.x");
  const auto u_names = read_names(solution_member(columns, "u"), "trajectory.columns.u");
  DataTable table;
  table.columns = x_names;
  table.state_columns = x_names.size() - std::min(x_names.size(), linear_controls(u_names));
  table.columns.insert(table.columns.end(), u_names.begin(), u_names.end());
  TrajectoryReader(trajectory).read(x_names.size(), u_names.size(), table);
  table.phases = read_phases(trajectory, table.times.size());
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

bool is_time_or_phase(std::string_view column) {
  return column == "t" || column == "time" || column == "phase";
}

std::optional<std::size_t> DataTable::find(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found != columns.end()) return static_cast<std::size_t>(found - columns.begin());
  if (!is_time_or_phase(column)) return std::nullopt;
  const auto as_state = find(std::string(kStatePrefix) + column);
  return as_state ? as_state : find(std::string(kControlPrefix) + column);
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
