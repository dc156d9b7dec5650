#pragma once

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Factor on the costs of a problem before its solve, so that tolerances, penalties and
/// regularization do not depend on the unit of the costs. A power of two brings the geometric mean
/// of the largest and the smallest weight near 2⁻⁵; the factor is 1 if that mean lies between 2⁻¹⁷
/// and 2⁷. Weights are those of costs and soft constraints, times the weights of their components
/// and the cost scale of their knot. Weights below 10⁻¹⁰ of the largest are ignored.
double cost_scale(const ShootingProblem& problem);

/// A negligible cost: that of a move by 10⁻⁶ units at the smallest nonzero weight, or at weight 1
/// if that is smaller. It is at least the cost of a move by 10⁻¹² at the largest weight, which is
/// rounding. Infinite if all weights are zero.
double least_cost(const ShootingProblem& problem);

/// The problem with all costs, soft constraints included, multiplied by `scale`. It shares the
/// models of `problem`.
ShootingProblem scale_costs(const ShootingProblem& problem, double scale);

}  // namespace conddp
