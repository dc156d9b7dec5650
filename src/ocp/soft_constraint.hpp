#pragma once

#include <vector>

#include "ocp/problem.hpp"

namespace conddp {

/// What is cut off of p = s − Π(s), where a multiplier ρ p would exceed its limit; with it the
/// derivative of the augmented Lagrangian is that of a penalty that grows linearly from there.
/// Rows of bounds one by one, `limit` is that of the multiplier divided by ρ.
template <class S>
S limit_outside(const S& p, const S& limit) {
  return max(-limit, min(limit, p));
}

/// The same of a cone's p with n rows, whose norm is limited.
template <class S>
void limit_cone(int n, const S& limit, S* p);

/// From the derivative of a cone's p, which is not cut off yet, to that of limit_cone.
template <class S>
void limit_cone_derivative(const S* p, int n, const S& limit, S* derivative);

/// Multipliers of values g that the augmented Lagrangian with penalty ρ and multipliers ν gives,
/// from s = g + ν/ρ: ρ (s − Π(s)), within the limits of a soft constraint. Both of c.term->rows.
void next_multipliers(const NodeConstraint& c, const double* s, double penalty, double* next);

/// How far g is from where it has to be: 0 of soft constraints, else distance_to_set.
double violation(const NodeConstraint& c, const double* g);
/// As of its term; of a soft constraint, outside of its set, the distance times what the
/// multipliers lack of their limit.
double complementarity(const NodeConstraint& c, const double* g, const double* multipliers);

/// What a soft constraint of a knot, l1 or l2, costs at values g, with the knot's parameters.
double soft_cost(const ConstraintTerm& term, const double* g, const double* parameters,
                 double cost_scale);
/// What all constraints that are soft by their distance cost, from the values of all rows. Those by
/// a square are among the costs of the acts.
double linear_soft_cost(const ShootingProblem& problem, const Eigen::VectorXd& values);

}  // namespace conddp
