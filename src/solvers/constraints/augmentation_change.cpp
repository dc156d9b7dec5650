#include "solvers/constraints/augmentation_change.hpp"

#include <algorithm>

#include "ocp/knot/augmented_term.hpp"

namespace conddp {

AugmentationChange::AugmentationChange(const ShootingProblem& problem)
    : problem_(problem), update_(problem) {
  int rows = 0;
  for (const NodeConstraint& c : problem.constraints()) rows = std::max(rows, c.term->rows);
  for (Term* term : {&before_, &after_}) {
    term->gradient.setZero(rows);
    term->curvature.setZero(rows * rows);
  }
  shifted_.setZero(rows);
}

void AugmentationChange::evaluate(const NodeConstraint& c, const Augmentation& augmentation,
                                  const Eigen::VectorXd& values, Term& term) {
  term.value = augment<double>(
      *c.term, {c.lower, c.upper, c.limit},
      {augmentation.penalty.data() + c.row, augmentation.shift.data() + c.row,
       augmentation.multiplier.data() + c.row},
      values.data() + c.row, {shifted_.data(), term.gradient.data(), term.curvature.data()});
}

bool AugmentationChange::apply(const Augmentation& from, const Augmentation& to,
                               Linearization& linearization) {
  bool changed = false;
  const std::vector<NodeConstraint>& constraints = problem_.constraints();
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const NodeConstraint& c = constraints[i];
    evaluate(c, from, linearization.constraint, before_);
    evaluate(c, to, linearization.constraint, after_);
    linearization.augmentation[c.node] += after_.value - before_.value;
    KnotLinearization& knot = linearization.knots[c.node];
    changed |= change_gradient(c, knot);
    collect_curvature(c, knot);
    const bool last_of_node = i + 1 == constraints.size() || constraints[i + 1].node != c.node;
    if (!last_of_node || update_.empty()) continue;
    changed = true;
    update_.apply(knot.hessian);
  }
  return changed;
}

/// Changes the gradient by the difference between after_ and before_ of one constraint. False if
/// they are equal.
bool AugmentationChange::change_gradient(const NodeConstraint& c, KnotLinearization& knot) {
  const auto C = rows_of(c, knot);
  auto gradient = after_.gradient.head(c.term->rows);
  gradient -= before_.gradient.head(c.term->rows);
  bool changed = false;
  for (int r = 0; r < c.term->rows; ++r) {
    if (gradient[r] == 0) continue;
    knot.gradient += gradient[r] * C.row(r).transpose();
    changed = true;
  }
  return changed;
}

/// Like change_gradient, for the update of the node's Hessian.
void AugmentationChange::collect_curvature(const NodeConstraint& c, const KnotLinearization& knot) {
  const int n = c.term->rows;
  const auto C = rows_of(c, knot);
  auto curvature = after_.curvature.head(c.term->is_cone() ? n * n : n);
  curvature -= before_.curvature.head(curvature.size());
  if (!c.term->is_cone()) {
    for (int r = 0; r < n; ++r)
      if (curvature[r] != 0) update_.add(C.row(r), curvature[r]);
  } else if ((curvature.array() != 0).any()) {
    update_.add(C, Eigen::Map<const Eigen::MatrixXd>(curvature.data(), n, n));
  }
}

}  // namespace conddp
