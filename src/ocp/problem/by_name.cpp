#include "ocp/problem/by_name.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>

namespace conddp {
namespace {

/// Index of the column with this name, or the number of columns if not found.
int index_of(const std::string& name, const std::vector<Column>& columns) {
  return static_cast<int>(std::ranges::find(columns, name, &Column::name) - columns.begin());
}

void add_violation(const std::string& name, const NodeConstraint& c, double distance,
                   std::vector<ConstraintViolation>& list) {
  auto entry = std::find_if(list.begin(), list.end(),
                            [&](const ConstraintViolation& v) { return v.name == name; });
  if (entry == list.end()) entry = list.insert(entry, {name, 0, -1});
  if (distance <= entry->value) return;
  entry->value = distance;
  entry->node = c.node;
}

using CostTable = std::vector<std::pair<std::string, std::vector<double>>>;

double distance(const NodeConstraint& c, const Eigen::VectorXd& values) {
  return distance_to_set(*c.term, values.data() + c.row, c.lower, c.upper);
}

/// The row of a name; a new row contains zeros.
std::vector<double>& find_or_add(const std::string& name, int nodes, CostTable& costs) {
  const auto found = std::find_if(costs.begin(), costs.end(),
                                  [&](const auto& entry) { return entry.first == name; });
  if (found != costs.end()) return found->second;
  return costs.emplace_back(name, std::vector<double>(nodes)).second;
}

}  // namespace

std::string constraint_name(const ShootingProblem& problem, const NodeConstraint& constraint) {
  return (constraint.node == problem.knots() ? "terminal/" : "") + constraint.term->name;
}

std::vector<std::pair<std::string, std::vector<double>>> costs_by_node(
    const ShootingProblem& problem, const NodeValues& values) {
  CostTable costs;
  const auto cost_of = [&](const std::string& name) -> std::vector<double>& {
    return find_or_add(name, problem.knots() + 1, costs);
  };
  for (int k = 0; k <= problem.knots(); ++k) {
    const KnotView& view = problem.knot(k);
    const std::span<const double> term_costs = values.term_costs(k);
    const std::span<const double> soft_costs = values.soft_costs(k);
    const std::string prefix = k == problem.knots() ? "terminal/" : "";
    for (std::size_t t = 0; t < view.model->costs().size(); ++t)
      cost_of(prefix + view.model->costs()[t].name)[k] += term_costs[t];
    const std::vector<ConstraintTerm>& constraints = view.model->constraints();
    for (std::size_t t = 0; t < constraints.size(); ++t)
      if (constraints[t].softness != Softness::hard)
        cost_of(prefix + constraints[t].name)[k] += soft_costs[t];
  }
  return costs;
}

std::vector<std::pair<std::string, double>> cost_by_name(const ShootingProblem& problem,
                                                         const NodeValues& values) {
  std::vector<std::pair<std::string, double>> sums;
  for (const auto& [name, costs] : costs_by_node(problem, values))
    sums.emplace_back(name, std::accumulate(costs.begin(), costs.end(), 0.0));
  return sums;
}

std::vector<ConstraintViolation> violations_by_name(const ShootingProblem& problem,
                                                    const Eigen::VectorXd& values) {
  std::vector<ConstraintViolation> list;
  for (const NodeConstraint& c : problem.constraints()) {
    if (c.is_soft()) continue;
    add_violation(constraint_name(problem, c), c, distance(c, values), list);
  }
  return list;
}

std::vector<ConstraintViolation> soft_violations(const ShootingProblem& problem,
                                                 const Trajectory& trajectory,
                                                 const Eigen::VectorXd& values) {
  std::vector<ConstraintViolation> list;
  for (const NodeConstraint& c : problem.soft_constraints()) {
    const double share =
        problem.knot(c.node).model->row_share(*c.term, trajectory.x(c.node).data());
    add_violation(constraint_name(problem, c), c, distance(c, values) / share, list);
  }
  return list;
}

std::vector<std::string> failed_functions(const ShootingProblem& problem) {
  std::vector<std::string> names;
  const auto add = [&names](const auto& of) {
    for (std::string& name : of.failed_functions())
      if (std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
  };
  const auto add_model = [&](const KnotModel& model) {
    add(model.system());
    for (const CostTerm& cost : model.costs()) add(*cost.residual);
    for (const ConstraintTerm& constraint : model.constraints()) add(*constraint.residual);
  };
  for (const Phase& phase : problem.phases()) add_model(*phase.model);
  add_model(*problem.terminal().model);
  return names;
}

ControlColumns::ControlColumns(const ShootingProblem& problem)
    : problem_(problem), phases_(problem.phases().size()) {
  // Jumps and impulses lack controls; the controls of an initial-state choice are of another kind.
  std::vector<bool> is_in_table(phases_.size(), false);
  for (int k = 0; k < problem.knots(); ++k)
    is_in_table[problem.knot(k).phase] = !problem.takes_no_time(k);
  for (std::size_t p = 0; p < phases_.size(); ++p) {
    if (!is_in_table[p]) continue;
    for (const Column& control : problem.phases()[p].model->system().control_columns()) {
      phases_[p].push_back(index_of(control.name, columns_));
      if (phases_[p].back() == count()) columns_.push_back(control);
    }
  }
  std::vector<int> all(columns_.size());
  std::iota(all.begin(), all.end(), 0);
  for (std::size_t p = 0; p < phases_.size(); ++p)
    if (phases_[p] == all) phases_[p].clear();
}

Eigen::VectorXd ControlColumns::row(int knot, const Eigen::VectorXd& own) const {
  return rows(knot, own);
}

Eigen::MatrixXd ControlColumns::rows(int knot, const Eigen::MatrixXd& own) const {
  if (!are_some(knot)) return own;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd table = Eigen::MatrixXd::Constant(count(), own.cols(), kNone);
  const std::span<const int> columns = columns_of(knot);
  for (std::size_t i = 0; i < columns.size(); ++i) table.row(columns[i]) = own.row(i);
  return table;
}

Eigen::VectorXd ControlColumns::own(int knot, const Eigen::VectorXd& row) const {
  if (!are_some(knot) || row.size() != count()) return row;
  const std::span<const int> columns = columns_of(knot);
  Eigen::VectorXd own(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) own[i] = row[columns[i]];
  return own;
}

}  // namespace conddp
