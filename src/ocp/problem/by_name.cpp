#include "ocp/problem/by_name.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>

#include "ocp/problem/soft_constraint.hpp"
#include "ocp/terms/soft_limit.hpp"

namespace conddp {
namespace {

std::string name_of(const ShootingProblem& problem, const NodeConstraint& c) {
  return (c.node == problem.knots() ? "terminal/" : "") + c.term->name;
}

void add_violation(const std::string& name, const Eigen::VectorXd& values, const NodeConstraint& c,
                   std::vector<ConstraintViolation>& list) {
  auto entry = std::find_if(list.begin(), list.end(),
                            [&](const ConstraintViolation& v) { return v.name == name; });
  if (entry == list.end()) entry = list.insert(entry, {name, 0, -1});
  const double distance = distance_to_set(*c.term, values.data() + c.row, c.lower, c.upper);
  if (distance <= entry->value) return;
  entry->value = distance;
  entry->node = c.node;
}

}  // namespace

std::vector<std::pair<std::string, std::vector<double>>> costs_by_node(
    const ShootingProblem& problem, const Trajectory& trajectory) {
  std::vector<std::pair<std::string, std::vector<double>>> costs;
  const auto cost_of = [&](const std::string& name) -> std::vector<double>& {
    for (auto& [known, values] : costs)
      if (known == name) return values;
    return costs.emplace_back(name, std::vector<double>(problem.knots() + 1)).second;
  };
  std::map<const KnotModel*, std::unique_ptr<KnotWorkspace<double>>> work;
  for (int k = 0; k <= problem.knots(); ++k) {
    const KnotView& view = problem.knot(k);
    auto& mine = work[view.model];
    if (!mine) mine = std::make_unique<KnotWorkspace<double>>(*view.model);
    const double* u = k < problem.knots() ? trajectory.u(k).data() : nullptr;
    view.model->evaluate(
        KnotInput<double>{trajectory.x(k).data(), u, view.parameters, view.dt, view.cost_scale},
        *mine);
    for (std::size_t t = 0; t < view.model->costs().size(); ++t)
      cost_of((k == problem.knots() ? "terminal/" : "") + view.model->costs()[t].name)[k] +=
          mine->term_costs[t];
    for (const ConstraintTerm& term : view.model->constraints())
      if (term.softness != Softness::hard)
        cost_of((k == problem.knots() ? "terminal/" : "") + term.name)[k] +=
            soft_cost(term, mine->constraint.data() + term.row, view.parameters, view.cost_scale);
  }
  return costs;
}

std::vector<std::pair<std::string, double>> cost_by_name(const ShootingProblem& problem,
                                                         const Trajectory& trajectory) {
  std::vector<std::pair<std::string, double>> sums;
  for (const auto& [name, values] : costs_by_node(problem, trajectory))
    sums.emplace_back(name, std::accumulate(values.begin(), values.end(), 0.0));
  return sums;
}

std::vector<ConstraintViolation> violations_by_name(const ShootingProblem& problem,
                                                    const Eigen::VectorXd& values) {
  std::vector<ConstraintViolation> list;
  for (const NodeConstraint& c : problem.constraints()) {
    if (c.is_soft()) continue;
    add_violation(name_of(problem, c), values, c, list);
  }
  return list;
}

std::vector<ConstraintViolation> soft_violations(const ShootingProblem& problem,
                                                 const Eigen::VectorXd& values) {
  std::vector<ConstraintViolation> list;
  for (const NodeConstraint& c : problem.soft_constraints())
    add_violation(name_of(problem, c), values, c, list);
  return list;
}

}  // namespace conddp
