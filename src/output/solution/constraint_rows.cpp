#include "output/solution/constraint_rows.hpp"

namespace conddp {

const ConstraintSpec* constraint_spec(const ProblemSpec& spec, const ShootingProblem& problem,
                                      const NodeConstraint& constraint) {
  const auto find = [&](const std::vector<ConstraintSpec>& list) -> const ConstraintSpec* {
    for (const ConstraintSpec& one : list)
      if (one.function.name.value == constraint.term->name) return &one;
    return nullptr;
  };
  // Constraints on running knots can also hold at the last node.
  if (constraint.node == problem.knots())
    if (const ConstraintSpec* found = find(spec.terminal_constraints)) return found;
  return find(spec.constraints);
}

namespace {

/// Names of the rows that are single columns.
std::vector<std::string> names_by_column(const Residual& residual,
                                         const std::vector<std::string>& columns) {
  std::vector<std::string> names;
  for (const RowBlock& block : residual.blocks())
    if (block.rows == 1 && block.columns.size() == 1 &&
        block.columns[0] < static_cast<int>(columns.size()))
      names.push_back(columns[block.columns[0]]);
  return names;
}

}  // namespace

std::vector<std::string> residual_row_names(const ProblemSpec& spec, const BuiltProblem& built,
                                            const ConstraintSpec& constraint,
                                            const Residual& residual) {
  std::vector<std::string> names = names_by_column(residual, tangent_columns(built));
  const auto complete = [&] { return static_cast<int>(names.size()) == residual.size(); };
  if (complete()) return names;
  Diagnostics ignored;  // the problem is already built
  for (const Plant& plant : built.plant.all_variants()) {
    const auto made =
        make_cost_residual(constraint.function, spec, plant, built.problem->ndx(), ignored);
    if (made) names = made->rows.names;
    if (complete()) return names;
  }
  names.clear();
  for (int i = 0; i < residual.size(); ++i) names.push_back(std::to_string(i + 1));
  return names;
}

}  // namespace conddp
