#include "solvers/iterate/control_curvature.hpp"

#include <algorithm>
#include <limits>

#include "ocp/knot/augmented_term.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

/// Largest diagonal entry of the costs among those that exceed rounding of the whole entry.
template <class Diagonal>
double largest_of_costs(const Eigen::VectorXd& costs, const Diagonal& whole) {
  double largest = 0;
  for (int i = 0; i < whole.size(); ++i)
    if (costs[i] > tuning::kRounding * whole[i]) largest = std::max(largest, costs[i]);
  return largest;
}

}  // namespace

ControlCurvature::ControlCurvature(const ShootingProblem& problem) : problem_(problem) {
  int rows = 0, controls = 0;
  for (const NodeConstraint& c : problem.constraints()) {
    if (!c.term->depends_on_control(problem.ndx())) continue;
    on_controls_.push_back(&c);
    rows = std::max(rows, c.term->rows);
  }
  for (int k = 0; k < problem.knots(); ++k) controls = std::max(controls, problem.nu(k));
  costs_.resize(controls);
  shifted_.resize(rows);
  multiplier_.resize(rows);
  curvature_.resize(rows * rows);
  product_.resize(rows, controls);
}

/// Subtracts a constraint's part of its knot's diagonal from costs_.
void ControlCurvature::subtract(const NodeConstraint& c, const Linearization& linearization,
                                const Augmentation& augmentation) {
  const int n = c.term->rows, nu = problem_.nu(c.node);
  augment<double>(*c.term, {c.lower, c.upper, c.limit},
                  {augmentation.penalty.data() + c.row, augmentation.shift.data() + c.row,
                   augmentation.multiplier.data() + c.row},
                  linearization.constraint.data() + c.row,
                  {shifted_.data(), multiplier_.data(), curvature_.data()});
  const auto C = linearization.knots[c.node]
                     .C.middleRows(c.row - problem_.constraint_offset(c.node), n)
                     .rightCols(nu);
  auto product = product_.topLeftCorner(n, nu);
  if (c.term->is_cone())
    product.noalias() = Eigen::Map<const Eigen::MatrixXd>(curvature_.data(), n, n).lazyProduct(C);
  else
    product = curvature_.head(n).asDiagonal() * C;
  for (int i = 0; i < nu; ++i) costs_[i] -= C.col(i).dot(product.col(i));
}

double ControlCurvature::least(const Linearization& linearization,
                               const Augmentation* augmentation) {
  double least = std::numeric_limits<double>::infinity();
  auto constraint = on_controls_.begin();
  for (int k = 0; k < problem_.knots(); ++k) {
    const auto all = linearization.knots[k].hessian().diagonal().tail(problem_.nu(k));
    costs_.head(all.size()) = all;
    for (; constraint != on_controls_.end() && (*constraint)->node == k; ++constraint)
      if (augmentation != nullptr) subtract(**constraint, linearization, *augmentation);
    const double largest = largest_of_costs(costs_, all);
    if (largest > 0) least = std::min(least, largest);
  }
  return least;
}

}  // namespace conddp
