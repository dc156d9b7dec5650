#include "ocp/problem/contradiction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "ocp/problem/node_evaluation.hpp"

namespace conddp {
namespace {

/// Where a coordinate may be, measured from the initial state and zero controls.
struct Interval {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  std::string name = {};  ///< of the constraint that narrowed it last, empty: bounds on the control
};

/// What is left of the coordinates of one node after another.
class Narrowing {
 public:
  explicit Narrowing(const ShootingProblem& problem) : problem_(problem), nodes_(problem) {}

  /// Constraints come node by node.
  std::optional<Contradiction> add(const NodeConstraint& c) {
    if (c.node != node_) begin(c.node);
    if (c.term->kind != ConstraintKind::bounds || c.is_soft()) return std::nullopt;
    int row = 0;
    for (const RowBlock& block : c.term->blocks) {
      if (block.rows == 1 && block.columns.size() == 1)
        if (auto found = narrow(c, row, coordinates_[block.columns[0]])) return found;
      row += block.rows;
    }
    return std::nullopt;
  }

 private:
  /// Of the controls, and the constraints' values at the initial state.
  void begin(int node) {
    node_ = node;
    const KnotModel& model = *problem_.knot(node).model;
    coordinates_.clear();
    for (int i = 0; i < model.nu(); ++i)
      coordinates_[model.ndx() + i] = {model.control_lower()[i], model.control_upper()[i]};
    const std::vector<double> u(model.nu(), 0.0);
    values_ = &nodes_.at(node, problem_.initial_state().data(), u.data()).constraint;
  }

  std::optional<Contradiction> narrow(const NodeConstraint& c, int row, Interval& known) const {
    const double here = (*values_)[c.term->row + row];
    const double lower = c.lower[row] - here, upper = c.upper[row] - here;
    // Differences of rounded numbers: bounds that meet may miss each other by that.
    const double slack =
        1e-12 * (1 + std::abs(here) + (std::isfinite(lower) ? std::abs(lower) : 0));
    if (lower > known.upper + slack || upper < known.lower - slack)
      return Contradiction{c.term->name, known.name, c.node, std::max(lower, known.lower) + here,
                           std::min(upper, known.upper) + here};
    if (lower > known.lower || upper < known.upper) known.name = c.term->name;
    known.lower = std::max(known.lower, lower);
    known.upper = std::min(known.upper, upper);
    return std::nullopt;
  }

  const ShootingProblem& problem_;
  NodeEvaluation nodes_;
  int node_ = -1;
  std::map<int, Interval> coordinates_;
  const AlignedVector<double>* values_ = nullptr;
};

}  // namespace

std::optional<Contradiction> find_contradiction(const ShootingProblem& problem) {
  Narrowing narrowing(problem);
  for (const NodeConstraint& c : problem.constraints())
    if (auto found = narrowing.add(c)) return found;
  return std::nullopt;
}

}  // namespace conddp
