#include "analysis/solution_comparison.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace conddp {
namespace {

using Json = nlohmann::json;
using Matrix = std::vector<std::vector<double>>;

constexpr const char* kQuaternion[] = {"qx", "qy", "qz", "qw"};

class Comparison {
 public:
  Comparison(const Json& golden, const Json& actual, const ComparisonTolerances& tolerances)
      : golden_(golden), actual_(actual), tolerances_(tolerances) {}

  std::vector<Difference> run() {
    texts("status");
    number("cost", golden_.at("cost"), actual_.at("cost"), cost_tolerance());
    costs_by_name();
    residuals();
    const Json& a = golden_.at("trajectory");
    const Json& b = actual_.at("trajectory");
    const auto times = a.at("t").get<std::vector<double>>();
    if (!same_grid(times, b.at("t").get<std::vector<double>>())) return differences_;
    for (const char* kind : {"x", "u"}) matrix(kind, a, b, times);
    return differences_;
  }

 private:
  void add(std::string quantity, std::string message) {
    differences_.push_back({std::move(quantity), std::move(message)});
  }

  void texts(const char* key) {
    if (golden_.at(key) != actual_.at(key))
      add(key, fmt::format("{} instead of {}", actual_.at(key).dump(), golden_.at(key).dump()));
  }

  double cost_tolerance() const {
    const Json& cost = golden_.at("cost");
    return tolerances_.cost_relative *
           std::max(1e-3, cost.is_number() ? std::abs(cost.get<double>()) : 1);
  }

  void number(const std::string& quantity, const Json& a, const Json& b, double tolerance) {
    if (a.is_null() && b.is_null()) return;
    if (!a.is_number() || !b.is_number()) {
      add(quantity, fmt::format("{} instead of {}", b.dump(), a.dump()));
      return;
    }
    const double difference = b.get<double>() - a.get<double>();
    if (!(std::abs(difference) <= tolerance))
      add(quantity, fmt::format("{:.9g} instead of {:.9g} (difference {:.2e}, tolerance {:.2e})",
                                b.get<double>(), a.get<double>(), difference, tolerance));
  }

  void costs_by_name() {
    const Json& a = golden_.at("cost_by_name");
    const Json& b = actual_.at("cost_by_name");
    for (const auto& [name, cost] : a.items()) {
      if (!b.contains(name))
        add("cost " + name, "is missing");
      else  // a sum is better determined than its parts
        number("cost " + name, cost, b.at(name), 100 * cost_tolerance());
    }
    for (const auto& [name, cost] : b.items())
      if (!a.contains(name)) add("cost " + name, "is new");
  }

  void residuals() {
    for (const auto& [name, golden] : golden_.at("residuals").items()) {
      const Json& actual = actual_.at("residuals").at(name);
      if (!golden.is_number() || !actual.is_number()) {
        if (golden != actual)
          add("residual " + name, fmt::format("{} instead of {}", actual.dump(), golden.dump()));
        continue;
      }
      const double allowed =
          std::max(tolerances_.residual_floor, tolerances_.residual_factor * golden.get<double>());
      if (!(actual.get<double>() <= allowed))
        add("residual " + name,
            fmt::format("{:.2e}, where at most {:.2e} is allowed", actual.get<double>(), allowed));
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

  void matrix(const char* kind, const Json& a, const Json& b, const std::vector<double>& times) {
    const auto names = a.at("columns").at(kind).get<std::vector<std::string>>();
    if (names != b.at("columns").at(kind).get<std::vector<std::string>>()) {
      add("trajectory", fmt::format("the columns of {} have other names", kind));
      return;
    }
    const auto golden = a.at(kind).get<Matrix>(), actual = b.at(kind).get<Matrix>();
    if (golden.size() != actual.size()) {
      add("trajectory",
          fmt::format("{} rows of {} instead of {}", actual.size(), kind, golden.size()));
      return;
    }
    for (std::size_t c = 0; c < names.size(); ++c) {
      if (is_quaternion(names, c)) {
        rotations(names[c], golden, actual, c, times);
        c += 3;
        continue;
      }
      column(names[c], golden, actual, c, times);
    }
  }

  static bool is_quaternion(const std::vector<std::string>& names, std::size_t c) {
    if (c + 4 > names.size()) return false;
    for (std::size_t i = 0; i < 4; ++i)
      if (!names[c + i].ends_with(kQuaternion[i])) return false;
    return true;
  }

  void column(const std::string& name, const Matrix& a, const Matrix& b, std::size_t c,
              const std::vector<double>& times) {
    double largest = 0, worst = 0;
    std::size_t at = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (c >= a[k].size() || c >= b[k].size()) continue;
      largest = std::max(largest, std::abs(a[k][c]));
      const double difference = std::abs(a[k][c] - b[k][c]);
      if (!(difference <= worst)) {
        worst = difference;
        at = k;
      }
    }
    const double allowed =
        tolerances_.trajectory_absolute + tolerances_.trajectory_relative * largest;
    if (!(worst <= allowed))
      add(fmt::format("trajectory {} at knot {} (t = {:.4g} s)", name, at, times[at]),
          fmt::format("{:.6g} instead of {:.6g} (tolerance {:.2e})", b[at][c], a[at][c], allowed));
  }

  void rotations(const std::string& name, const Matrix& a, const Matrix& b, std::size_t c,
                 const std::vector<double>& times) {
    double worst = 0;
    std::size_t at = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      // sin of half the angle from the vector part of a⁻¹ b: accurate where the angle is small.
      const double *p = &a[k][c], *q = &b[k][c];
      const double x = p[3] * q[0] - p[0] * q[3] - p[1] * q[2] + p[2] * q[1];
      const double y = p[3] * q[1] - p[1] * q[3] - p[2] * q[0] + p[0] * q[2];
      const double z = p[3] * q[2] - p[2] * q[3] - p[0] * q[1] + p[1] * q[0];
      const double angle = 2 * std::asin(std::min(1.0, std::sqrt(x * x + y * y + z * z)));
      if (!(angle <= worst)) {
        worst = angle;
        at = k;
      }
    }
    if (!(worst <= tolerances_.rotation))
      add(fmt::format("trajectory {} at knot {} (t = {:.4g} s)",
                      name.substr(0, name.size() - 2) + "rotation", at, times[at]),
          fmt::format("turned by {:.3g} rad (tolerance {:.2e})", worst, tolerances_.rotation));
  }

  const Json& golden_;
  const Json& actual_;
  const ComparisonTolerances& tolerances_;
  std::vector<Difference> differences_;
};

/// Rounds every number in place to ten significant digits, which its shortest text then shows.
void round_numbers(Json& value) {
  if (value.is_number_float())
    value = std::stod(fmt::format("{:.9e}", value.get<double>()));
  else if (value.is_structured())
    for (Json& child : value) round_numbers(child);
}

}  // namespace

std::vector<Difference> compare_solutions(const Json& golden, const Json& actual,
                                          const ComparisonTolerances& tolerances) {
  try {
    return Comparison(golden, actual, tolerances).run();
  } catch (const Json::exception& e) {
    return {{"document", std::string("a field is missing or has another type: ") + e.what()}};
  }
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
