#include "solvers/augmentation_change.hpp"

#include <algorithm>
#include <cmath>

#include "ocp/soft_constraint.hpp"

namespace conddp {

AugmentationChange::AugmentationChange(const ShootingProblem& problem)
    : problem_(problem), update_(problem) {
  int rows = 0;
  for (const NodeConstraint& c : problem.constraints()) rows = std::max(rows, c.term->rows);
  for (Term* term : {&before_, &after_}) {
    term->gradient.setZero(rows);
    term->hessian.setZero(rows, rows);
  }
  shifted_.setZero(rows);
  outside_.setZero(rows);
  slope_.setZero(rows * rows);
}

void AugmentationChange::evaluate(const NodeConstraint& c, const Augmentation& augmentation,
                                  const Eigen::VectorXd& values, Term& term) {
  const int n = c.term->rows;
  const double rho = augmentation.penalty[c.row], limit = c.limit / rho;
  auto shifted = shifted_.head(n);
  shifted = values.segment(c.row, n) + augmentation.shift.segment(c.row, n);
  auto gradient = term.gradient.head(n);
  if (c.term->has_bounds()) {
    term.value = 0;
    for (int r = 0; r < n; ++r) {
      const double s = shifted[r], outside = outside_bounds(s, c.lower[r], c.upper[r]);
      const double cut = limit_outside(outside, limit);
      const bool curved = (s <= c.lower[r] || s >= c.upper[r]) && std::abs(outside) <= limit;
      term.value += rho * cut * (outside - 0.5 * cut);
      gradient[r] = rho * cut;
      term.hessian(r, 0) = curved ? rho : 0;
    }
    return;
  }
  auto outside = outside_.head(n);
  outside_cone(shifted.data(), n, outside.data());
  outside_cone_derivative(shifted.data(), n, slope_.data());
  gradient = outside;
  if (c.is_soft()) {
    limit_cone_derivative(outside.data(), n, limit, slope_.data());
    limit_cone(n, limit, gradient.data());
  }
  term.value = rho * gradient.dot(outside - 0.5 * gradient);
  gradient *= rho;
  term.hessian.topLeftCorner(n, n) = rho * Eigen::Map<const Eigen::MatrixXd>(slope_.data(), n, n);
}

bool AugmentationChange::apply(const Augmentation& from, const Augmentation& to,
                               Linearization& linearization) {
  bool changed = false;
  const std::vector<NodeConstraint>& constraints = problem_.constraints();
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const NodeConstraint& c = constraints[i];
    const int n = c.term->rows;
    evaluate(c, from, linearization.constraint, before_);
    evaluate(c, to, linearization.constraint, after_);
    linearization.augmentation[c.node] += after_.value - before_.value;
    KnotLinearization& knot = linearization.knots[c.node];
    const auto C = knot.C.middleRows(c.row - problem_.constraint_offset(c.node), n);
    auto gradient = after_.gradient.head(n);
    gradient -= before_.gradient.head(n);
    for (int r = 0; r < n; ++r) {
      if (gradient[r] == 0) continue;
      knot.gradient += gradient[r] * C.row(r).transpose();
      changed = true;
    }
    if (c.term->has_bounds()) {
      for (int r = 0; r < n; ++r) {
        const double curvature = after_.hessian(r, 0) - before_.hessian(r, 0);
        if (curvature != 0) update_.add(C.row(r), curvature);
      }
    } else {
      auto hessian = after_.hessian.topLeftCorner(n, n);
      hessian -= before_.hessian.topLeftCorner(n, n);
      if ((hessian.array() != 0).any()) update_.add(C, hessian);
    }
    const bool last_of_node = i + 1 == constraints.size() || constraints[i + 1].node != c.node;
    if (!last_of_node || update_.empty()) continue;
    changed = true;
    update_.apply(knot.hessian);
  }
  return changed;
}

}  // namespace conddp
