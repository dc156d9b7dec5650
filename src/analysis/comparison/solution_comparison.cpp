#include "analysis/comparison/solution_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/json/json_document.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;
using Matrix = std::vector<std::vector<double>>;

constexpr const char* kQuaternion[] = {"qx", "qy", "qz", "qw"};

/// Reads a number; null becomes NaN.
double read_number(const Json& value, const std::string& what) {
  if (value.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (!value.is_number()) throw MalformedSolution{fmt::format("{} is not a number", what)};
  return value.get<double>();
}

using NamedValues = std::map<std::string, double>;

NamedValues read_named(const Json& solution, const char* key) {
  NamedValues values;
  const Json& object = solution_member(solution, key);
  if (!object.is_object()) throw MalformedSolution{fmt::format("'{}' has no names", key)};
  for (const auto& [name, value] : object.items())
    values[name] = read_number(value, fmt::format("{}.{}", key, name));
  return values;
}

/// States or controls of a trajectory, and the names of their columns.
struct Table {
  std::vector<std::string> names;
  Matrix rows;
};

std::vector<std::string> read_names(const Json& list, const char* kind) {
  if (!list.is_array()) throw MalformedSolution{fmt::format("'columns.{}' is not a list", kind)};
  std::vector<std::string> names;
  for (const Json& name : list) {
    if (!name.is_string()) throw MalformedSolution{fmt::format("'columns.{}' has no names", kind)};
    names.push_back(name);
  }
  return names;
}

/// Reads one number per column, or an empty row at an impulse.
std::vector<double> read_row(const Json& numbers, const char* kind, std::size_t columns) {
  if (!numbers.is_array() || (!numbers.empty() && numbers.size() != columns))
    throw MalformedSolution{fmt::format("a row of '{}' should have {} numbers", kind, columns)};
  std::vector<double> row;
  for (const Json& value : numbers) row.push_back(read_number(value, kind));
  return row;
}

/// Reads the rows of states or controls. If the initial state is free, the first controls are the
/// choice; they are left out because the second state shows them.
Table read_table(const Json& trajectory, const char* kind, std::size_t rows,
                 bool first_is_choice = false) {
  Table table{read_names(solution_member(solution_member(trajectory, "columns"), kind), kind), {}};
  const Json& list = solution_list(trajectory, kind);
  if (list.size() != rows)
    throw MalformedSolution{fmt::format("'{}' should have {} rows", kind, rows)};
  for (const Json& numbers : list) {
    if (first_is_choice && table.rows.empty()) {
      table.rows.emplace_back();
      continue;
    }
    table.rows.push_back(read_row(numbers, kind, table.names.size()));
  }
  return table;
}

/// The compared part of a solution.
struct Compared {
  explicit Compared(const Json& solution) {
    status = solution_text(solution, "status");
    cost = read_number(solution_member(solution, "cost"), "the cost");
    costs = read_named(solution, "cost_by_name");
    residuals = read_named(solution, "residuals");
    const Json& trajectory = solution_member(solution, "trajectory");
    const Json& t = solution_member(trajectory, "t");
    if (!t.is_array() || t.empty())
      throw MalformedSolution{"'trajectory.t' is not a list of times"};
    for (const Json& time : t) times.push_back(read_number(time, "a time"));
    x = read_table(trajectory, "x", times.size());
    u = read_table(trajectory, "u", times.size() - 1, times.size() > 1 && times[1] == times[0]);
    for (const auto& row : x.rows)
      if (row.empty()) throw MalformedSolution{"a row of 'x' is empty"};
  }

  std::string status;
  double cost;
  NamedValues costs, residuals;
  std::vector<double> times;
  Table x, u;
};

std::string number_text(double value) {
  return std::isfinite(value) ? fmt::format("{:.9g}", value) : "a number that is not finite";
}

class Comparison {
 public:
  Comparison(const Compared& golden, const Compared& actual, const ComparisonTolerances& tolerances)
      : golden_(golden), actual_(actual), tolerances_(tolerances) {}

  std::vector<Difference> run() {
    if (golden_.status != actual_.status)
      add("status", fmt::format("{} instead of {}", actual_.status, golden_.status));
    number("cost", golden_.cost, actual_.cost, cost_tolerance());
    costs_by_name();
    residuals();
    if (!same_grid(golden_.times, actual_.times)) return differences_;
    table("x", golden_.x, actual_.x);
    table("u", golden_.u, actual_.u);
    return differences_;
  }

 private:
  void add(std::string quantity, std::string message) {
    differences_.push_back({std::move(quantity), std::move(message)});
  }

  double cost_tolerance() const {
    const double size = std::isfinite(golden_.cost) ? std::abs(golden_.cost) : 1;
    return tolerances_.cost_relative * std::max(kSmallestCostSize, size);
  }

  void number(const std::string& quantity, double golden, double actual, double tolerance) {
    const double difference = actual - golden;
    if (std::abs(difference) <= tolerance) return;
    if (!std::isfinite(golden) && !std::isfinite(actual)) return;
    std::string message = fmt::format("{} instead of {}", number_text(actual), number_text(golden));
    if (std::isfinite(difference))
      message += fmt::format(" (difference {:.2e}, tolerance {:.2e})", difference, tolerance);
    add(quantity, std::move(message));
  }

  void costs_by_name() {
    for (const auto& [name, cost] : golden_.costs) {
      const auto found = actual_.costs.find(name);
      if (found == actual_.costs.end())
        add("cost " + name, "is missing");
      else  // a sum is better determined than its parts
        number("cost " + name, cost, found->second, 100 * cost_tolerance());
    }
    for (const auto& [name, cost] : actual_.costs)
      if (!golden_.costs.contains(name)) add("cost " + name, "is new");
  }

  void residuals() {
    for (const auto& [name, golden] : golden_.residuals) {
      const auto found = actual_.residuals.find(name);
      if (found == actual_.residuals.end()) {
        add("residual " + name, "is missing");
        continue;
      }
      const double actual = found->second;
      if (std::isnan(golden) && std::isnan(actual)) continue;
      const double allowed =
          std::max(tolerances_.residual_floor, tolerances_.residual_factor * golden);
      if (!(actual <= allowed))
        add("residual " + name,
            fmt::format("{}, where at most {:.2e} is allowed",
                        std::isfinite(actual) ? fmt::format("{:.2e}", actual) : number_text(actual),
                        allowed));
    }
  }

  bool same_grid(const std::vector<double>& a, const std::vector<double>& b) {
    if (a.size() != b.size()) {
      add("trajectory", fmt::format("{} nodes instead of {}", b.size(), a.size()));
      return false;
    }
    for (std::size_t k = 0; k < a.size(); ++k)
      if (!(std::abs(a[k] - b[k]) <= 1e-9 * (1 + std::abs(a[k])))) {
        add("trajectory",
            fmt::format("node {} at t = {:.9g} s instead of {:.9g} s", k, b[k], a[k]));
        return false;
      }
    return true;
  }

  bool have_same_sizes(const char* kind, const Table& golden, const Table& actual) {
    for (std::size_t k = 0; k < golden.rows.size(); ++k)
      if (golden.rows[k].size() != actual.rows[k].size()) {
        add("trajectory", fmt::format("knot {} has {} numbers of {} instead of {}", k,
                                      actual.rows[k].size(), kind, golden.rows[k].size()));
        return false;
      }
    return true;
  }

  void table(const char* kind, const Table& golden, const Table& actual) {
    if (golden.names != actual.names) {
      add("trajectory", fmt::format("the columns of {} have other names", kind));
      return;
    }
    if (!have_same_sizes(kind, golden, actual)) return;
    for (std::size_t c = 0; c < golden.names.size(); ++c) {
      if (is_quaternion(golden.names, c)) {
        rotations(golden.names[c], golden.rows, actual.rows, c);
        c += 3;
        continue;
      }
      if (!is_slack(golden.names[c]))
        column(golden.names[c], golden.rows, actual.rows, c, kind == std::string_view("u"));
    }
  }

  /// True for slacks of contact-implicit steps. If a force acts, velocities and forces determine
  /// them; otherwise only their small weight does.
  static bool is_slack(const std::string& name) {
    const std::string last = name.substr(name.rfind('/') + 1);
    return name.starts_with("contact/") && (last.starts_with("slip_") || last.starts_with("use"));
  }

  static bool is_quaternion(const std::vector<std::string>& names, std::size_t c) {
    if (c + 4 > names.size()) return false;
    for (std::size_t i = 0; i < 4; ++i)
      if (!names[c + i].ends_with(kQuaternion[i])) return false;
    return true;
  }

  /// Largest difference over the knots. A difference that is not finite exceeds all others: missing
  /// numbers agree with nothing.
  struct Worst {
    double difference = 0;
    std::size_t knot = 0;

    void take(std::size_t k, double of_knot) {
      if (!std::isfinite(of_knot)) of_knot = std::numeric_limits<double>::infinity();
      if (!(of_knot > difference)) return;
      difference = of_knot;
      knot = k;
    }
  };

  /// True if both solutions lack a control of other phases at a knot that has other numbers.
  static bool both_lack(const std::vector<double>& a, const std::vector<double>& b, std::size_t c) {
    const auto has_numbers = [](const std::vector<double>& row) {
      return std::any_of(row.begin(), row.end(),
                         [](double number) { return std::isfinite(number); });
    };
    return std::isnan(a[c]) && std::isnan(b[c]) && has_numbers(a) && has_numbers(b);
  }

  void column(const std::string& name, const Matrix& a, const Matrix& b, std::size_t c,
              bool of_control) {
    double largest = 0;
    Worst worst;
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (a[k].empty() || (of_control && both_lack(a[k], b[k], c))) continue;
      if (std::isfinite(a[k][c])) largest = std::max(largest, std::abs(a[k][c]));
      worst.take(k, std::abs(a[k][c] - b[k][c]));
    }
    const double allowed =
        tolerances_.trajectory_absolute + tolerances_.trajectory_relative * largest;
    if (worst.difference <= allowed) return;
    const std::size_t at = worst.knot;
    add(fmt::format("trajectory {} at knot {} (t = {:.4g} s)", name, at, golden_.times[at]),
        fmt::format("{} instead of {} (tolerance {:.2e})", number_text(b[at][c]),
                    number_text(a[at][c]), allowed));
  }

  void rotations(const std::string& name, const Matrix& a, const Matrix& b, std::size_t c) {
    Worst worst;
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (a[k].empty()) continue;
      // The vector part of a⁻¹ b gives the sine of half the angle, which is accurate for small
      // angles.
      const double *p = &a[k][c], *q = &b[k][c];
      const double x = p[3] * q[0] - p[0] * q[3] - p[1] * q[2] + p[2] * q[1];
      const double y = p[3] * q[1] - p[1] * q[3] - p[2] * q[0] + p[0] * q[2];
      const double z = p[3] * q[2] - p[2] * q[3] - p[0] * q[1] + p[1] * q[0];
      const double sine = std::sqrt(x * x + y * y + z * z);
      worst.take(k, std::isfinite(sine) ? 2 * std::asin(std::min(1.0, sine)) : sine);
    }
    if (worst.difference <= tolerances_.rotation) return;
    add(fmt::format("trajectory {} at knot {} (t = {:.4g} s)",
                    name.substr(0, name.size() - 2) + "rotation", worst.knot,
                    golden_.times[worst.knot]),
        std::isfinite(worst.difference) ? fmt::format("turned by {:.3g} rad (tolerance {:.2e})",
                                                      worst.difference, tolerances_.rotation)
                                        : "not finite");
  }

  const Compared& golden_;
  const Compared& actual_;
  const ComparisonTolerances& tolerances_;
  std::vector<Difference> differences_;
};

/// Rounds every number in place to ten significant digits, which its shortest text then shows.
void round_numbers(Json& value) {
  if (value.is_number_float())
    value = std::strtod(fmt::format("{:.9e}", value.get<double>()).c_str(), nullptr);
  else if (value.is_structured())
    for (Json& child : value) round_numbers(child);
}

}  // namespace

std::vector<Difference> compare_solutions(const Json& golden, const Json& actual,
                                          const ComparisonTolerances& tolerances) {
  for (const Json* solution : {&golden, &actual})
    if (auto defect = comparison_defect(*solution)) return {{"document", *std::move(defect)}};
  return Comparison(Compared(golden), Compared(actual), tolerances).run();
}

std::optional<std::string> comparison_defect(const Json& solution) {
  try {
    const Compared compared(solution);
  } catch (const MalformedSolution& malformed) {
    return malformed.what();
  }
  return std::nullopt;
}

Json golden_part(const Json& solution) {
  Json part;
  for (const char* key :
       {"format", "solver", "status", "iterations", "cost", "cost_by_name", "residuals"})
    part[key] = solution.at(key);
  for (const char* key : {"columns", "t", "x", "u"})
    part["trajectory"][key] = solution.at("trajectory").at(key);
  round_numbers(part);
  return part;
}

}  // namespace conddp
