#pragma once

#include "ocp/terms/constraint.hpp"

namespace conddp {

/// p = s − Π(s), clamped where a multiplier ρ p would exceed its limit; with it the
/// derivative of the augmented Lagrangian is that of a penalty that grows linearly from there.
/// Rows of bounds one by one, `limit` is that of the multiplier divided by ρ.
template <class S>
S limit_outside(const S& p, const S& limit) {
  return max(-limit, min(limit, p));
}

/// The same of a cone's p with n rows, whose norm is clamped.
template <class S>
void limit_cone(int n, const S& limit, S* p);

/// From the derivative of a cone's p, which is not clamped yet, to that of limit_cone.
template <class S>
void limit_cone_derivative(const S* p, int n, const S& limit, S* derivative);

/// The distance of values g from their set to a power, by rows its sum; of a cone its own. Bounds
/// of `term.rows` numbers each, which terms with bounds alone read.
double soft_distance(const ConstraintTerm& term, const double* g, const double* lower,
                     const double* upper, double power);
/// What a soft constraint of a knot, l1 or l2, costs at values g, with the knot's parameters.
double soft_cost(const ConstraintTerm& term, const double* g, const double* parameters,
                 double cost_scale);

}  // namespace conddp
