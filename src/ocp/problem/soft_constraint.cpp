#include "ocp/problem/soft_constraint.hpp"

#include <algorithm>
#include <cmath>

#include "ocp/terms/soft_limit.hpp"

namespace conddp {

void next_multipliers(const NodeConstraint& c, const double* s, double penalty, double* next) {
  const int n = c.term->rows;
  const double limit = c.limit / penalty;
  if (c.term->has_bounds()) {
    for (int i = 0; i < n; ++i)
      next[i] = limit_outside(outside_bounds(s[i], c.lower[i], c.upper[i]), limit);
  } else {
    outside_cone(s, n, next);
    if (c.is_soft()) limit_cone(n, limit, next);
  }
  for (int i = 0; i < n; ++i) next[i] *= penalty;
}

double violation(const NodeConstraint& c, const double* g) {
  return c.is_soft() ? 0 : distance_to_set(*c.term, g, c.lower, c.upper);
}

namespace {

/// Complementarity of a row with bounds: outside its bounds, the multiplier must equal the limit;
/// it never exceeds the limit.
double row_complementarity(const NodeConstraint& c, int i, double value, double multiplier) {
  const double outside = outside_bounds(value, c.lower[i], c.upper[i]);
  const double lacks = c.limit - (outside > 0 ? multiplier : -multiplier);
  return std::max({std::abs(outside) * std::abs(lacks), std::abs(multiplier) - c.limit,
                   bound_complementarity(value, c.lower[i], c.upper[i], multiplier)});
}

}  // namespace

double complementarity(const NodeConstraint& c, const double* g, const double* multipliers) {
  const int n = c.term->rows;
  if (!c.is_soft()) return complementarity(*c.term, g, c.lower, c.upper, multipliers);
  if (c.term->has_bounds()) {
    double largest = 0;
    for (int i = 0; i < n; ++i)
      largest = std::max(largest, row_complementarity(c, i, g[i], multipliers[i]));
    return largest;
  }
  // At a solution, νᵀg equals the cost of the cone's distance: the multipliers are at their limit.
  const double paid = c.limit * distance_to_set(*c.term, g, c.lower, c.upper);
  double product = -paid, square = 0;
  for (int i = 0; i < n; ++i) product += multipliers[i] * g[i];
  for (int i = 0; i + 1 < n; ++i) square += multipliers[i] * multipliers[i];
  return std::max({std::abs(product), distance_to_polar_cone(multipliers, n),
                   std::hypot(std::sqrt(square), multipliers[n - 1]) - c.limit});
}

double linear_soft_cost(const ShootingProblem& problem, const Eigen::VectorXd& values) {
  double sum = 0;
  for (const NodeConstraint& c : problem.constraints())
    if (c.is_soft())
      sum += c.limit * soft_distance(*c.term, values.data() + c.row, c.lower, c.upper, 1);
  return sum;
}

}  // namespace conddp
