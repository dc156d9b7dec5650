#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "problem_file/data_table.hpp"
#include "problem_file/source_text.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

struct Malformed {
  std::string message;
};

/// The place of a byte of the text (the end of the text where it is shorter).
Mark mark_at(const std::string& text, std::size_t byte, int source, const Diagnostics& out) {
  const std::string_view before = std::string_view(text).substr(0, std::min(byte, text.size()));
  const std::size_t start = before.rfind('\n') + 1;  // npos + 1 is 0
  const int line = 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
  const int column = out.character_column(source, line, static_cast<int>(before.size() - start));
  return {source, line, column};
}

/// Keeps the trajectory alone: gains and multipliers of a long solution would fill the memory.
Json parse_trajectory(const std::string& text) {
  constexpr int kMaxDepth = 100;         // a configuration is as deep as a problem file may be
  constexpr int kMaxValues = 5'000'000;  // a document takes many times the memory of its text
  int values = 0;
  bool wanted = true;  // whether the values are kept; it is asked for those that are not, too
  std::array<std::set<std::string>, kMaxDepth + 2> keys;  // of the objects that are open
  const auto keep = [&](int depth, Json::parse_event_t event, Json& value) {
    if (depth > kMaxDepth) throw Malformed{"it is nested too deeply"};
    if (event == Json::parse_event_t::object_start) keys[depth + 1].clear();
    if (wanted && event == Json::parse_event_t::value && ++values > kMaxValues)
      throw Malformed{fmt::format("it has more than {} values", kMaxValues)};
    if (event != Json::parse_event_t::key) return true;
    const std::string& key = value.get_ref<const std::string&>();
    if (!keys[depth].insert(key).second)
      throw Malformed{fmt::format("the key '{}' is given twice", key)};
    if (depth == 1) wanted = key == "format" || key == "trajectory";
    return depth != 1 || wanted;
  };
  return Json::parse(text, keep);
}

/// What the parser says, without its own bookkeeping: "... syntax error while parsing value - ...".
std::string reason(const Json::exception& e) {
  const std::string_view text = e.what();
  for (const std::string_view start : {"syntax error ", "] "})
    if (const std::size_t at = text.find(start); at != text.npos)
      return std::string(text.substr(at + start.size()));
  return std::string(text);
}

const Json& member(const Json& object, const char* key) {
  if (!object.is_object() || !object.contains(key))
    throw Malformed{fmt::format("'{}' is missing", key)};
  return object[key];
}

std::vector<std::string> read_names(const Json& array, const char* what) {
  std::vector<std::string> names;
  if (!array.is_array()) throw Malformed{fmt::format("'{}' is no list", what)};
  for (const Json& name : array) {
    if (!name.is_string()) throw Malformed{fmt::format("'{}' has an entry that is no name", what)};
    if (std::find(names.begin(), names.end(), name.get_ref<const std::string&>()) != names.end())
      throw Malformed{fmt::format("'{}' stands twice in {}", name.get<std::string>(), what)};
    names.push_back(name);
  }
  return names;
}

/// Appends one row of numbers (null: an empty cell) to the table's row.
void append_row(const Json& array, std::size_t count, const std::string& what,
                std::vector<std::optional<double>>& row) {
  if (!array.is_array() || array.size() != count)
    throw Malformed{fmt::format("{} should have {} numbers", what, count)};
  for (const Json& value : array) {
    if (value.is_null())
      row.emplace_back();
    else if (value.is_number() && std::isfinite(value.get<double>()))
      row.push_back(value.get<double>());
    else
      throw Malformed{fmt::format("{} has an entry that is no finite number", what)};
  }
}

DataTable read_trajectory(const Json& solution) {
  constexpr std::string_view kFamily = "conddp.solution/", kVersion = "1";
  const Json& format = member(solution, "format");
  if (!format.is_string() || !format.get_ref<const std::string&>().starts_with(kFamily))
    throw Malformed{"it is no solution of conddp"};
  if (const std::string version = format.get<std::string>().substr(kFamily.size());
      version != kVersion)
    throw Malformed{
        fmt::format("it has format {}, and this version reads format {}", version, kVersion)};
  const Json& trajectory = member(solution, "trajectory");
  const Json& columns = member(trajectory, "columns");
  DataTable table;
  const auto x_names = read_names(member(columns, "x"), "trajectory.columns.x");
  const auto u_names = read_names(member(columns, "u"), "trajectory.columns.u");
  table.columns = x_names;
  table.state_columns = x_names.size();
  table.columns.insert(table.columns.end(), u_names.begin(), u_names.end());
  const Json& t = member(trajectory, "t");
  const Json& x = member(trajectory, "x");
  const Json& u = member(trajectory, "u");
  if (!t.is_array() || !x.is_array() || !u.is_array() || t.empty() || x.size() != t.size() ||
      u.size() + 1 != t.size())
    throw Malformed{"the lists t, x and u of its trajectory do not fit together"};
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (!t[k].is_number() || (k > 0 && t[k].get<double>() < table.times.back()))
      throw Malformed{"its times do not increase"};
    if (k > 0 && t[k].get<double>() == table.times.back()) {
      // An impulse takes no time: what holds after it stands for the moment.
      table.times.pop_back();
      table.rows.pop_back();
    }
    table.times.push_back(t[k]);
    auto& row = table.rows.emplace_back();
    append_row(x[k], x_names.size(), fmt::format("trajectory.x[{}]", k), row);
    const bool controlled = k < u.size() && !(u[k].is_array() && u[k].empty());
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
  const int source = out.add_source(name, text);
  try {
    DataTable table = read_trajectory(parse_trajectory(text));
    table.file = name;
    return table;
  } catch (const Json::parse_error& e) {
    out.error({mark_at(text, e.byte > 0 ? e.byte - 1 : 0, source, out), {}},
              "not valid JSON: " + reason(e));
  } catch (const Malformed& e) {
    out.error({{source, 0, 0}, {}}, fmt::format("the solution cannot be used: {}", e.message));
  } catch (const Json::out_of_range& e) {
    // "number overflow parsing '1e999'": the place is where that number stands.
    const std::string_view what = e.what();
    const std::size_t open = std::min(what.find('\''), what.size());
    const std::string_view number =
        what.substr(open, what.rfind('\'') > open ? what.rfind('\'') - open : 0);
    const std::size_t byte = number.size() > 1 ? text.find(number.substr(1)) : 0;
    out.error({mark_at(text, byte, source, out), {}}, "a number of the solution is out of range");
  } catch (const Json::exception& e) {
    out.error({{source, 0, 0}, {}}, fmt::format("the solution cannot be used: {}", reason(e)));
  }
  return std::nullopt;
}

std::optional<std::size_t> DataTable::find(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

std::optional<DataTable> load_data_table(const std::filesystem::path& file, const Place& place,
                                         Diagnostics& out) {
  InputFile input{file.string(), {}};
  const auto text = read_text(file, kMaxDataBytes, place, input.sha256, out);
  if (!text) return std::nullopt;
  out.add_data_file(std::move(input));
  if (file.extension() == ".json") return parse_solution(*text, file.string(), out);
  return parse_csv(*text, file.string(), out);
}

}  // namespace conddp
