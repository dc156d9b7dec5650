#pragma once

#include "ocp/problem/problem.hpp"

namespace conddp {

/// What the costs of a problem are multiplied by before its solve, so that tolerances, penalties
/// and regularisations mean the same whatever the unit of the costs: a power of two that brings the
/// geometric mean of the largest and the smallest weight near 2⁻⁵, and 1 where that mean is between
/// 2⁻¹⁷ and 2⁷. Weights are those of costs and soft constraints, times the weights of their
/// components and the cost scale of their knot; less than 10⁻¹⁰ of the largest does not count.
double cost_scale(const ShootingProblem& problem);

/// A cost that is nothing: what moves by 10⁻⁶ units change at the least of these weights, all but
/// zero, or at a weight of 1 where that is less; and no less than rounding, moves by 10⁻¹² at the
/// largest weight. Infinite where nothing costs anything.
double least_cost(const ShootingProblem& problem);

/// The problem with costs, soft constraints among them, that are `scale` times as large. It shares
/// the models of `problem`.
ShootingProblem scale_costs(const ShootingProblem& problem, double scale);

}  // namespace conddp
