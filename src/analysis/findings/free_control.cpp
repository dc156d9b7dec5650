#include "analysis/findings/free_control.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace conddp {
namespace {

using Columns = std::vector<int>;

bool reads(const RowBlock& block, const Columns& columns) {
  return std::ranges::any_of(columns, [&](int column) {
    return std::ranges::find(block.columns, column) != block.columns.end();
  });
}

/// True if one of the rows that read the columns counts.
bool counts(const CostTerm& cost, const Columns& columns) {
  const std::vector<double>& weights = cost.activation.weights;
  int first = 0;
  for (const RowBlock& block : cost.residual->blocks()) {
    const bool weighs = weights.empty() ||
                        std::any_of(weights.begin() + first, weights.begin() + first + block.rows,
                                    [](double weight) { return weight != 0; });
    if (weighs && reads(block, columns)) return true;
    first += block.rows;
  }
  return false;
}

bool is_free(const KnotView& knot, int control) {
  const KnotModel& model = *knot.model;
  if (std::isfinite(model.control_lower()[control]) ||
      std::isfinite(model.control_upper()[control]))
    return false;
  const Columns columns = {model.ndx() + control, model.step().control_column(control)};
  const bool costs = std::ranges::any_of(model.costs(), [&](const CostTerm& cost) {
    return knot.parameters[cost.weight] != 0 && counts(cost, columns);
  });
  const bool holds = std::ranges::any_of(model.constraints(), [&](const ConstraintTerm& term) {
    return std::ranges::any_of(term.blocks,
                               [&](const RowBlock& block) { return reads(block, columns); });
  });
  return !costs && !holds;
}

}  // namespace

std::optional<FreeControl> free_control(const ShootingProblem& problem) {
  for (int k = 0; k < problem.knots(); ++k) {
    if (problem.takes_no_time(k)) continue;
    const KnotView& knot = problem.knot(k);
    const System& system = knot.model->system();
    for (int i = 0; i < system.actuators(); ++i)
      if (is_free(knot, i))
        return FreeControl{system.control_columns()[i].name, problem.phases()[knot.phase].name, k};
  }
  return std::nullopt;
}

}  // namespace conddp
