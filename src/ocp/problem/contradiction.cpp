#include "ocp/problem/contradiction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace conddp {
namespace {

/// Where a coordinate may be, measured from the initial state and zero controls.
struct Interval {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  std::string name = {};  ///< of the constraint that narrowed it last, empty: bounds on the control
};

}  // namespace

std::optional<Contradiction> find_contradiction(const ShootingProblem& problem) {
  std::map<const KnotModel*, std::unique_ptr<KnotWorkspace<double>>> work;
  const std::vector<double>& x0 = problem.initial_state();
  std::map<int, Interval> coordinates;
  int node = -1;
  for (const NodeConstraint& c : problem.constraints()) {
    const KnotView& view = problem.knot(c.node);
    const KnotModel& model = *view.model;
    auto& mine = work[&model];
    if (!mine) mine = std::make_unique<KnotWorkspace<double>>(model);
    if (c.node != node) {
      node = c.node;
      coordinates.clear();
      for (int i = 0; i < model.nu(); ++i)
        coordinates[model.ndx() + i] = {model.control_lower()[i], model.control_upper()[i]};
      const std::vector<double> u(model.nu(), 0.0);
      model.evaluate(
          KnotInput<double>{x0.data(), u.data(), view.parameters, view.dt, view.cost_scale}, *mine);
    }
    if (c.term->kind != ConstraintKind::bounds || c.is_soft()) continue;
    int row = 0;
    for (const RowBlock& block : c.term->blocks) {
      const int at = row;
      row += block.rows;
      if (block.rows != 1 || block.columns.size() != 1) continue;
      const double here = mine->constraint[c.term->row + at];
      const double lower = c.lower[at] - here, upper = c.upper[at] - here;
      Interval& known = coordinates[block.columns[0]];
      // Differences of rounded numbers: bounds that meet may miss each other by that.
      const double slack =
          1e-12 * (1 + std::abs(here) + (std::isfinite(lower) ? std::abs(lower) : 0));
      if (lower > known.upper + slack || upper < known.lower - slack)
        return Contradiction{c.term->name, known.name, c.node, std::max(lower, known.lower) + here,
                             std::min(upper, known.upper) + here};
      if (lower > known.lower || upper < known.upper) known.name = c.term->name;
      known.lower = std::max(known.lower, lower);
      known.upper = std::min(known.upper, upper);
    }
  }
  return std::nullopt;
}

}  // namespace conddp
