#include "output/report/constraint_curves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/json/ordered_json.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "problem_file/assemble/problem_names.hpp"

namespace conddp {
namespace {

/// The constraints with the same name, in the order of their nodes.
struct Named {
  std::string name;
  std::vector<NodeConstraint> at;

  int first() const { return at.front().node; }
  int nodes() const { return at.back().node - first() + 1; }
  /// True if the values can be drawn row by row over time. In phases of other systems (`variants`),
  /// different residuals have different states and controls.
  bool has_rows(bool variants) const {
    const ConstraintTerm& term = *at.front().term;
    if (!term.has_bounds()) return false;
    for (std::size_t i = 1; i < at.size(); ++i)
      if (at[i].node == at[i - 1].node || at[i].term->rows != term.rows ||
          at[i].term->kind != term.kind || (variants && at[i].term->residual != term.residual))
        return false;
    return true;
  }
};

std::vector<Named> by_name(const ShootingProblem& problem) {
  std::vector<Named> list;
  const auto add = [&](const NodeConstraint& constraint, const char* kind) {
    const std::string name = constraint_name(problem, constraint) + kind;
    auto entry = std::find_if(list.begin(), list.end(),
                              [&](const Named& named) { return named.name == name; });
    if (entry == list.end()) entry = list.insert(entry, {name, {}});
    entry->at.push_back(constraint);
  };
  for (const NodeConstraint& constraint : problem.constraints())
    if (!constraint.is_soft()) add(constraint, "");
  for (const NodeConstraint& constraint : problem.soft_constraints()) add(constraint, " (soft)");
  return list;
}

/// Distance to the nearest bound, negative outside.
double margin(const NodeConstraint& c, const double* g) {
  const int n = c.term->rows;
  if (c.term->has_pairs()) return -distance_to_set(*c.term, g, c.lower, c.upper);
  if (!c.term->has_bounds()) {
    double square = 0;
    for (int i = 0; i + 1 < n; ++i) square += g[i] * g[i];
    return g[n - 1] - std::sqrt(square);
  }
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < n; ++i) least = std::min({least, g[i] - c.lower[i], c.upper[i] - g[i]});
  return least;
}

/// Numbers of nodes as JSON, null for missing numbers.
OrderedJson list_json(const std::vector<double>& values) {
  OrderedJson list = OrderedJson::array();
  for (const double value : values) list.push_back(eight_digits(value));
  return list;
}

/// Bounds of nodes as JSON, a single number if all nodes have the same bound.
OrderedJson bounds_json(const std::vector<double>& values) {
  const bool same =
      std::all_of(values.begin(), values.end(), [&](double v) { return v == values.front(); });
  return same ? eight_digits(values.front()) : list_json(values);
}

OrderedJson rows_json(const BuiltProblem& built, const ShootingProblem& problem, const Named& named,
                      const Eigen::VectorXd& g) {
  const std::vector<double> none(named.nodes(), std::nan(""));
  const ConstraintTerm& term = *named.at.front().term;
  std::vector<std::string> names;
  if (term.kind == ConstraintKind::bounds)
    names = constraint_row_names(built, problem, named.at.front());
  names.resize(term.rows, named.name);
  OrderedJson rows = OrderedJson::array();
  for (int i = 0; i < term.rows; ++i) {
    std::vector<double> values = none, lower = none, upper = none;
    for (const NodeConstraint& c : named.at) {
      values[c.node - named.first()] = g[c.row + i];
      lower[c.node - named.first()] = c.lower[i];
      upper[c.node - named.first()] = c.upper[i];
    }
    rows.push_back({{"name", names[i]},
                    {"values", list_json(values)},
                    {"lower", bounds_json(lower)},
                    {"upper", bounds_json(upper)}});
  }
  return rows;
}

OrderedJson margin_rows(const Named& named, const Eigen::VectorXd& g) {
  std::vector<double> least(named.nodes(), std::nan(""));
  for (const NodeConstraint& c : named.at) {
    double& value = least[c.node - named.first()];
    value = std::fmin(value, margin(c, g.data() + c.row));
  }
  OrderedJson rows = OrderedJson::array();
  rows.push_back(
      {{"name", "margin"}, {"values", list_json(least)}, {"lower", 0}, {"upper", nullptr}});
  return rows;
}

/// Appends all constraints of one problem: the whole problem, or one with only an omitted
/// constraint.
void append_curves(const BuiltProblem& built, const ShootingProblem& problem,
                   const Trajectory& trajectory, bool left_out, OrderedJson& list) {
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(trajectory, evaluation);
  const Eigen::VectorXd& g = evaluation.constraint;
  for (const Named& named : by_name(problem)) {
    std::vector<double> violation(named.nodes(), std::nan(""));
    for (const NodeConstraint& c : named.at) {
      double& value = violation[c.node - named.first()];
      value = std::fmax(value, distance_to_set(*c.term, g.data() + c.row, c.lower, c.upper));
    }
    const bool rows = named.has_rows(!built.plant.variants.empty());
    list.push_back({{"name", named.name + (left_out ? " (left out)" : "")},
                    {"left_out", left_out},
                    {"first", named.first()},
                    {"violation", list_json(violation)},
                    {"margin", !rows},
                    {"rows", rows ? rows_json(built, problem, named, g) : margin_rows(named, g)}});
  }
}

}  // namespace

OrderedJson constraint_curves(const BuiltProblem& built, const Trajectory& trajectory) {
  OrderedJson list = OrderedJson::array();
  append_curves(built, *built.problem, trajectory, false, list);
  for (const DroppedConstraint& dropped : built.dropped)
    if (dropped.alone) append_curves(built, *dropped.alone, trajectory, true, list);
  return list;
}

}  // namespace conddp
