#include <algorithm>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

/// Terms of a combination by name: columns of the state and of the control. A control has the
/// prefix u/ if a state has its name. The first term is the constant.
struct Combinable {
  std::vector<std::string> names{"constant"};
  std::vector<LinearCombination::Term> terms{{}};

  /// `controls`: number of leading controls to include.
  Combinable(const System& system, int controls) {
    for (const auto& segment : system.manifold().segments())
      for (int i = 0; segment.part == StateManifold::Part::flat && i < segment.n; ++i) {
        if (!system.has_state(segment.x + i)) continue;
        names.push_back(system.state_columns()[segment.x + i].name);
        terms.push_back({0, false, segment.x + i, segment.dx + i});
      }
    for (int i = 0; i < controls; ++i) {
      const std::string& name = system.control_columns()[i].name;
      const bool taken = std::find(names.begin(), names.end(), name) != names.end();
      names.push_back((taken ? "u/" : "") + name);
      terms.push_back({0, true, i, -1});
    }
  }
};

/// Adds a column with its factor to a row; an unknown column is reported.
bool add_term(const Combinable& combinable, const Name& name, double factor, LinearCombination& row,
              Diagnostics& out) {
  const auto& [known, terms] = combinable;
  const auto found = std::find(known.begin(), known.end(), name.value);
  if (found == known.end()) {
    out.error(name.place,
              fmt::format("'{}' is not a column of the state or control that can be combined",
                          name.value),
              name_hint(name.value, known, "columns"), known);
    return false;
  }
  if (found == known.begin()) {
    row.constant = factor;
    return true;
  }
  row.terms.push_back(terms[found - known.begin()]);
  row.terms.back().factor = factor;
  return true;
}

std::optional<std::vector<LinearCombination>> find_combinations(
    const std::vector<NamedNumbers>& given, const ResidualContext& context) {
  const System& system = *context.plant.system;
  const bool linear = context.spec.has_linear_controls();
  const Combinable combinable(system, linear ? system.actuators() : system.nu());
  std::vector<LinearCombination> rows;
  bool good = true;
  for (const NamedNumbers& factors : given) {
    LinearCombination& row = rows.emplace_back();
    for (const auto& [name, factor] : factors)
      good &= add_term(combinable, name, factor, row, context.out);
    const bool costs_time = row.constant != 0 && context.spec.first_free_duration() != nullptr;
    if (!row.terms.empty() || costs_time || !good) continue;
    context.out.error(context.cost.residual.place, "a row combines nothing",
                      "give the factor of a column");
    good = false;
  }
  if (!good) return std::nullopt;
  return rows;
}

std::optional<CostResidual> make_combination(const ResidualContext& context) {
  const std::vector<NamedNumbers> given = context.cost.keys.value(key::combination_rows);
  auto combinations = find_combinations(given, context);
  if (!combinations) return std::nullopt;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < given.size(); ++i) names.push_back(std::to_string(i + 1));
  CostResidual result;
  result.residual = combination_residual(context.ndx, std::move(*combinations));
  result.rows = {"rows", std::move(names)};
  return result;
}

}  // namespace

std::span<const ResidualDefinition> combination_residuals() {
  static const ResidualDefinition all[] = {
      {.name = "combination",
       .description = "linear combinations of columns of the state and of the control",
       .unit = "same as the columns",
       .synonyms = {"linear", "time", "duration"},
       .keys = {&rows_key()},
       .make = make_combination}};
  return all;
}

}  // namespace conddp
