#include <fmt/format.h>

#include "problem_file/assemble/problem_names.hpp"
#include "summary/summary.hpp"

namespace conddp {
namespace {

std::string what(DerivativeKind kind) {
  switch (kind) {
    case DerivativeKind::dynamics:
      return "dynamics";
    case DerivativeKind::residual:
      return "residual";
    case DerivativeKind::constraint:
      return "constraint";
    case DerivativeKind::gradient:
      return "cost gradient";
    case DerivativeKind::hessian:
      break;
  }
  return "Hessian";
}

std::string number_text(const OrderedJson& value) {
  return value.is_null() ? "not finite" : fmt::format("{:.10g}", value.get<double>());
}

/// The worst row of a comparison, and its term.
struct ComparedRow {
  std::string row = "cost";
  std::string cost, constraint;
};

ComparedRow row_of(const DerivativeComparison& c, const KnotModel& model,
                   const BuiltProblem& built) {
  ComparedRow row;
  if (c.kind == DerivativeKind::dynamics) row.row = tangent_columns(built)[c.row];
  if (c.kind == DerivativeKind::residual) {
    const CostTerm& term = model.costs()[c.term];
    row.cost = term.name;
    row.row = cost_row_names(built, term, c.phase)[c.row];
  }
  if (c.kind == DerivativeKind::constraint) {
    row.constraint = model.constraints()[c.term].name;
    row.row = fmt::format("row {}", c.row);
  }
  return row;
}

}  // namespace

OrderedJson derivatives_json(const std::vector<DerivativeComparison>& comparisons,
                             const BuiltProblem& built) {
  const ShootingProblem& problem = *built.problem;
  const int phases = static_cast<int>(problem.phases().size());
  const std::vector<std::string> tangent = tangent_columns(built);
  OrderedJson list = OrderedJson::array();
  bool holds = true;
  for (const DerivativeComparison& c : comparisons) {
    const bool terminal = c.phase == phases;
    const Phase& phase = terminal ? problem.terminal() : problem.phases()[c.phase];
    const auto [row, cost, constraint] = row_of(c, *phase.model, built);
    std::vector<std::string> columns = tangent;
    const bool own = phase.instant || !built.plant.variants.empty();
    const auto& controls = own ? phase.model->system().control_columns() : built.control_columns;
    for (const Column& control : controls) columns.push_back(control.name);
    const bool within = c.error <= kDerivativeTolerance;
    const bool second = c.kind == DerivativeKind::hessian;
    holds = holds && within;
    list.push_back({{"phase", phase.name},
                    {"derivative", what(c.kind)},
                    {"cost", cost},
                    {"constraint", constraint},
                    {"knots", c.knots},
                    {"entries", c.entries},
                    {"holds", within},
                    {"worst",
                     {{"row", second ? columns[c.row] : row},
                      {"column", columns[c.column]},
                      {"knot", c.knot},
                      {"displaced", c.displaced},
                      {"analytic", finite_or_null(c.analytic)},
                      {"reference", finite_or_null(c.reference)},
                      {"relative_error", finite_or_null(c.error)}}}});
  }
  return {{"holds", holds},
          {"tolerance", kDerivativeTolerance},
          {"reference", runs_code(built) ? "dual numbers and differences" : "dual numbers"},
          {"compared", std::move(list)}};
}

std::string derivatives_text(const OrderedJson& derivatives) {
  const std::string reference = derivatives["reference"];
  std::string text = fmt::format(
      "derivatives against {} at the first guess and beside it, relative error up to "
      "{:g}: {}\n",
      reference, derivatives["tolerance"].get<double>(),
      derivatives["holds"].get<bool>() ? "all hold" : "SOME ARE WRONG");
  for (const auto& c : derivatives["compared"]) {
    const auto& worst = c["worst"];
    std::string name = c["derivative"].get<std::string>();
    if (const std::string cost = c["cost"]; !cost.empty()) name += " of " + cost;
    if (const std::string of = c["constraint"]; !of.empty()) name += " " + of;
    const auto& error = worst["relative_error"];
    text += fmt::format(
        "  {:<6}{}, {}: worst {} at d {} / d {}: {}, by {} {} (knot {}{})\n",
        c["holds"].get<bool>() ? "" : "WRONG", c["phase"].get<std::string>(), name,
        error.is_null() ? "without bound" : fmt::format("{:.2g}", error.get<double>()),
        worst["row"].get<std::string>(), worst["column"].get<std::string>(),
        number_text(worst["analytic"]), reference, number_text(worst["reference"]),
        worst["knot"].get<int>(), worst["displaced"].get<bool>() ? ", beside the guess" : "");
  }
  return text;
}

}  // namespace conddp
