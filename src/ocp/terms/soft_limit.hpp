#pragma once

#include "ocp/terms/constraint.hpp"

namespace conddp {

/// p = s − Π(s) for one row of bounds, clamped such that the multiplier ρ p does not exceed its
/// limit. The augmented Lagrangian then grows linearly beyond the limit. `limit` is the multiplier
/// limit divided by ρ.
template <class S>
S limit_outside(const S& p, const S& limit) {
  return max(-limit, min(limit, p));
}

/// Counterpart of limit_outside for p of a cone with n rows; clamps the norm of p.
template <class S>
void limit_cone(int n, const S& limit, S* p);

/// Converts the derivative of a cone's p, not yet clamped, into that of limit_cone.
template <class S>
void limit_cone_derivative(const S* p, int n, const S& limit, S* derivative);

/// Distance of values g from their set, raised to a power: summed over rows, or of the whole cone.
/// The bounds have `term.rows` numbers each and are read only for terms with bounds.
double soft_distance(const ConstraintTerm& term, const double* g, const double* lower,
                     const double* upper, double power);
/// Cost of a knot's soft constraint, l1 or l2, at values g, from the knot's parameters.
double soft_cost(const ConstraintTerm& term, const double* g, const double* parameters,
                 double cost_scale);

}  // namespace conddp
