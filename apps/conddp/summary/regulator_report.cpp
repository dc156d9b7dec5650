#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/terminal/terminal_set.hpp"
#include "base/json/ordered_json.hpp"
#include "summary/summary.hpp"

namespace conddp {
namespace {

/// Matrices with more columns are only printed as JSON.
constexpr std::size_t kMostColumns = 8;

OrderedJson vector_json(const Eigen::VectorXd& v) {
  return std::vector<double>(v.begin(), v.end());
}

OrderedJson matrix_json(const Eigen::MatrixXd& M) {
  OrderedJson rows = OrderedJson::array();
  for (int i = 0; i < M.rows(); ++i) rows.push_back(vector_json(M.row(i)));
  return rows;
}

OrderedJson eigenvalues_json(const Eigen::VectorXcd& values) {
  OrderedJson list = OrderedJson::array();
  for (const std::complex<double>& value : values)
    list.push_back(
        {{"real", value.real()}, {"imaginary", value.imag()}, {"modulus", std::abs(value)}});
  return list;
}

OrderedJson set_json(const TerminalSet& set, bool constrained) {
  OrderedJson bounds = OrderedJson::array();
  for (const TerminalBound& bound : set.bounds)
    bounds.push_back({{"name", bound.name}, {"distance", bound.distance}, {"level", bound.level}});
  return {{"level", finite_or_null(set.level)},
          {"constraint", constrained},
          {"bounds", std::move(bounds)}};
}

OrderedJson conditions_json(const TerminalConditions& conditions) {
  OrderedJson list = OrderedJson::array();
  for (const TerminalCondition& c : conditions.conditions)
    list.push_back({{"name", c.name},
                    {"meaning", c.meaning},
                    {"holds", c.holds},
                    {"figure", finite_or_null(c.figure)},
                    {"level", c.level}});
  OrderedJson enough = nullptr;
  if (conditions.decrease.level > 0)
    enough = {{"level", conditions.decrease.level}, {"factor", conditions.decrease.factor}};
  return {{"level",
           conditions.conditions.empty() ? OrderedJson(nullptr) : OrderedJson(conditions.level)},
          {"samples", conditions.samples},
          {"checked", std::move(list)},
          {"enough", std::move(enough)}};
}

std::string row_text(const OrderedJson& row) {
  std::string text;
  for (const auto& value : row) text += fmt::format(" {:>12.6g}", value.get<double>());
  return text;
}

/// Rows under a title, unless they are too long.
std::string matrix_lines(const std::string& title, const OrderedJson& rows) {
  const std::size_t columns = rows.empty() ? 0 : rows[0].size();
  if (columns > kMostColumns)
    return fmt::format("  {:<16}{} x {}, printed with --json\n", title, rows.size(), columns);
  std::string text;
  for (const auto& row : rows)
    text += fmt::format("  {:<16}{}\n", text.empty() ? title : "", row_text(row));
  return text;
}

std::string eigenvalue_line(const OrderedJson& values) {
  std::string text;
  for (std::size_t i = 0; i < std::min(values.size(), kMostColumns); ++i)
    text += fmt::format("{}{:.6f}", i == 0 ? "" : ", ", values[i]["modulus"].get<double>());
  return fmt::format("  {:<16}|λ| of A − BK: {}{}\n", "closed loop", text,
                     values.size() > kMostColumns ? ", ..." : "");
}

std::string set_lines(const OrderedJson& set) {
  if (set["level"].is_null())
    return fmt::format("  {:<16}nothing bounds the set (x ⊖ x̄)ᵀP(x ⊖ x̄) ≤ level\n", "set");
  const auto& narrowest = set["bounds"][0];
  return fmt::format("  {:<16}(x ⊖ x̄)ᵀP(x ⊖ x̄) ≤ {:.10g}{}, within '{}' ({:.4g} away)\n", "set",
                     set["level"].get<double>(),
                     set["constraint"].get<bool>() ? ", a constraint" : "",
                     narrowest["name"].get<std::string>(), narrowest["distance"].get<double>());
}

/// The weight that the decrease of A4 requires.
std::string weight_text(double decrease, const OrderedJson& enough) {
  if (decrease > 0)
    return fmt::format("enough with {:.6g} times the weight", std::max(1.0, 1 / decrease));
  if (enough.is_null()) return "and no weight is enough at any level that was tested";
  return fmt::format(
      "and no weight is enough at this level; {:.6g} times the weight is at level {:.3g}",
      enough["factor"].get<double>(), enough["level"].get<double>());
}

/// Explanation of a condition's figure.
std::string figure_text(const OrderedJson& condition, const OrderedJson& enough) {
  if (condition["figure"].is_null()) return "no finite figure";
  const double figure = condition["figure"].get<double>();
  const std::string name = condition["name"];
  if (name == "A3") return fmt::format("largest value after a step by the level: {:.6g}", figure);
  if (name == "A4")
    return fmt::format("least decrease by the stage cost: {:.6g}, {}", figure,
                       weight_text(figure, enough));
  return fmt::format("largest violation: {:.3g}", figure);
}

/// The samples for checking the conditions.
std::string samples_text(const OrderedJson& conditions) {
  if (conditions["level"].is_null()) return "P is zero: nothing to sample";
  if (conditions["samples"] == 0) return "the set is the equilibrium alone: nothing to sample";
  return fmt::format("{} samples of the set of level {:.6g}, nonlinear map",
                     conditions["samples"].get<int>(), conditions["level"].get<double>());
}

std::string condition_lines(const OrderedJson& conditions) {
  std::string text = fmt::format("  {:<16}{}\n", "conditions", samples_text(conditions));
  for (const auto& c : conditions["checked"]) {
    const double level = c["level"].get<double>();
    text += fmt::format("  {:<16}{} {}: {}; {}{}\n", "", c["name"].get<std::string>(),
                        c["holds"].get<bool>() ? "holds" : "does not hold",
                        c["meaning"].get<std::string>(), figure_text(c, conditions["enough"]),
                        c["holds"].get<bool>() ? ""
                        : level > 0            ? fmt::format("; holds at level {:.3g}", level)
                                               : "; holds at no level that was tested");
  }
  return text;
}

}  // namespace

OrderedJson regulator_json(const BuiltProblem& built, double constraint_tolerance) {
  const TerminalLqr& lqr = *built.terminal_lqr;
  const TerminalIngredients& own = lqr.ingredients;
  const TerminalConditions conditions = check_terminal_conditions(
      own, {.weight = lqr.weight, .level = lqr.set.level, .tolerance = constraint_tolerance});
  return {{"state", own.x},
          {"control", vector_json(own.u)},
          {"drift", own.drift},
          {"columns", tangent_columns(built)},
          {"weight", lqr.weight},
          {"directions", own.tangent.cols()},
          {"P", matrix_json(own.P)},
          {"K", matrix_json(own.K)},
          {"eigenvalues", eigenvalues_json(own.regulator.eigenvalues)},
          {"residual", own.regulator.residual},
          {"stage_cost", own.cost},
          {"stage_slope", own.gradient.cwiseAbs().maxCoeff()},
          {"set", set_json(lqr.set, lqr.constrained)},
          {"conditions", conditions_json(conditions)}};
}

std::string regulator_text(const OrderedJson& t) {
  std::string text = fmt::format(
      "terminal cost {:.6g} · ½ (x ⊖ x̄)ᵀP(x ⊖ x̄) of the linear-quadratic regulator u = ū − K (x ⊖ "
      "x̄)\n",
      t["weight"].get<double>());
  text += fmt::format("  {:<16}{} of {} directions of the state; it drifts by {:.2g} in a second\n",
                      "equilibrium", t["directions"].get<int>(), t["columns"].size(),
                      t["drift"].get<double>());
  if (t["control"].size() <= kMostColumns)
    text += fmt::format("  {:<16}{}\n", "control ū", row_text(t["control"]));
  text += matrix_lines("P", t["P"]) + matrix_lines("K", t["K"]);
  text += eigenvalue_line(t["eigenvalues"]);
  text += fmt::format("  {:<16}relative residual of the Riccati equation {:.2g}\n", "accuracy",
                      t["residual"].get<double>());
  text += fmt::format("  {:<16}at the equilibrium {:.6g}, its slope {:.3g}\n", "stage cost",
                      t["stage_cost"].get<double>(), t["stage_slope"].get<double>());
  return text + set_lines(t["set"]) + condition_lines(t["conditions"]);
}

}  // namespace conddp
