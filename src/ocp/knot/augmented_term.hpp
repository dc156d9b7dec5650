#pragma once

#include "ocp/knot/gauss_newton.hpp"
#include "ocp/terms/constraint.hpp"

namespace conddp {

/// Set of a constraint at a node: bounds of its rows, read only for terms with bounds, and the
/// limit on the multipliers of an l1-soft constraint.
template <class S>
struct RowSet {
  const S* lower;
  const S* upper;
  S limit;
};

/// Penalty, shift and multiplier of each row in the augmentation of a constraint.
template <class S>
struct RowPenalty {
  const S* penalty;
  const S* shift;
  const S* multiplier;
};

/// Workspace of one constraint: shifted values and weights of its rows and, unless null,
/// ∂weight/∂g.
template <class S>
struct RowSlopes {
  S *shifted, *weight, *curvature;
};

namespace detail {

/// Distance beyond which the cost of an l1-soft constraint grows linearly.
template <class S>
S soft_limit(const RowSet<S>& set, const S& penalty) {
  return set.limit / max(penalty, S(1e-200));
}

/// ½ penalty dist² of bounds and its derivatives, without the multipliers that `augment` adds.
template <class S>
S augment_bounds(const ConstraintTerm& term, const RowSet<S>& set, const S* penalty,
                 const RowSlopes<S>& to) {
  const bool limited = term.softness == Softness::l1;
  for (int i = 0; i < term.rows; ++i) {
    const S outside = outside_bounds(to.shifted[i], set.lower[i], set.upper[i]);
    to.weight[i] = limited ? limit_outside(outside, soft_limit(set, penalty[i])) : outside;
    if (to.curvature == nullptr) continue;
    to.curvature[i] = select(to.shifted[i] <= set.lower[i], penalty[i],
                             select(to.shifted[i] >= set.upper[i], penalty[i], S(0.0)));
    if (limited)
      to.curvature[i] =
          select(abs(outside) <= soft_limit(set, penalty[i]), to.curvature[i], S(0.0));
  }
  S value(0.0);
  // Skip the sum, a chain of dependent additions, if all rows hold, as most constraints do.
  if (all_zero(to.weight, term.rows)) return value;
  for (int i = 0; i < term.rows; ++i) {
    const S outside = outside_bounds(to.shifted[i], set.lower[i], set.upper[i]);
    value += penalty[i] * to.weight[i] * (outside - S(0.5) * to.weight[i]);
  }
  return value;
}

/// Derivatives for complementary pairs, which add nothing to the value. The smaller value of a pair
/// must vanish, whatever its multiplier.
template <class S>
void augment_pairs(int rows, const S* penalty, const S* g, const RowSlopes<S>& to) {
  for (int i = 0; i < rows; ++i) {
    const auto larger = i % 2 == 0 ? g[i] > g[i + 1] : g[i] >= g[i - 1];
    to.weight[i] = select(larger, min(to.shifted[i], S(0.0)), to.shifted[i]);
    if (to.curvature != nullptr)
      to.curvature[i] =
          select(larger, select(to.shifted[i] <= S(0.0), penalty[i], S(0.0)), penalty[i]);
  }
}

/// Second-order cone counterpart of augment_bounds; the curvature is a full matrix.
template <class S>
S augment_cone(const ConstraintTerm& term, const RowSet<S>& set, const S* penalty,
               const RowSlopes<S>& to) {
  S value(0.0);
  const int n = term.rows;
  const bool limited = term.softness == Softness::l1;
  outside_cone(to.shifted, n, to.weight);
  if (to.curvature != nullptr) {
    outside_cone_derivative(to.shifted, n, to.curvature);
    if (limited) limit_cone_derivative(to.weight, n, soft_limit(set, penalty[0]), to.curvature);
    for (int i = 0; i < n * n; ++i) to.curvature[i] *= penalty[0];
  }
  // ½ p² up to the limit and linear with the same slope beyond: p·q − ½ q² with q clamped.
  for (int i = 0; i < n; ++i) to.shifted[i] = to.weight[i];
  if (limited) limit_cone(n, soft_limit(set, penalty[0]), to.weight);
  for (int i = 0; i < n; ++i)
    value += penalty[0] * to.weight[i] * (to.shifted[i] - S(0.5) * to.weight[i]);
  return value;
}

}  // namespace detail

/// Value that a constraint adds to the cost, or to the augmentation, at its values g: ½ penalty
/// dist² + νᵀg, linear beyond the limit of an l1-soft constraint. Also writes the resulting
/// multiplier of each row to `weight` and, unless null, ∂weight/∂g to `curvature`: a diagonal, or
/// the full matrix of a cone. `shifted` and `weight` have `rows` numbers.
template <class S>
S augment(const ConstraintTerm& term, const RowSet<S>& set, const RowPenalty<S>& given, const S* g,
          const RowSlopes<S>& to) {
  for (int i = 0; i < term.rows; ++i) to.shifted[i] = g[i] + given.shift[i];
  S value(0.0);
  if (term.has_bounds())
    value = detail::augment_bounds(term, set, given.penalty, to);
  else if (term.has_pairs())
    detail::augment_pairs(term.rows, given.penalty, g, to);
  else
    value = detail::augment_cone(term, set, given.penalty, to);
  for (int i = 0; i < term.rows; ++i)
    to.weight[i] = given.penalty[i] * to.weight[i] + given.multiplier[i];
  if (all_zero(given.multiplier, term.rows)) return value;
  for (int i = 0; i < term.rows; ++i) value += given.multiplier[i] * g[i];
  return value;
}

}  // namespace conddp
