#pragma once

#include "ocp/terms/soft_limit.hpp"

namespace conddp {

/// The set of a constraint at a node: `rows` bounds, which nothing but terms with bounds look at,
/// and what the multipliers of one that is soft by its distance cannot exceed.
template <class S>
struct RowSet {
  const S* lower;
  const S* upper;
  S limit;
};

/// What an augmentation asks of a constraint's rows.
template <class S>
struct RowPenalty {
  const S* penalty;
  const S* shift;
  const S* multiplier;
};

/// What a constraint adds to the cost at its values g, soft or by the augmentation: ½ penalty dist²
/// + νᵀg, linear where the weight of a soft one limits it. With the multiplier that this gives to
/// each row and, where asked for, ∂weight/∂g: a diagonal, or all of a cone's. `shifted` and
/// `weight` have room for `rows` numbers.
template <class S>
S augment(const ConstraintTerm& term, const RowSet<S>& set, const RowPenalty<S>& given, const S* g,
          S* shifted, S* weight, S* curvature) {
  S value(0.0);
  const S* penalty = given.penalty;
  const int n = term.rows;
  const bool limited = term.softness == Softness::l1;
  const auto limit = [&](int row) { return set.limit / max(penalty[row], S(1e-200)); };
  for (int i = 0; i < n; ++i) shifted[i] = g[i] + given.shift[i];
  if (term.has_bounds()) {
    for (int i = 0; i < n; ++i) {
      const S outside = outside_bounds(shifted[i], set.lower[i], set.upper[i]);
      weight[i] = limited ? limit_outside(outside, limit(i)) : outside;
      value += penalty[i] * weight[i] * (outside - S(0.5) * weight[i]);
      if (curvature == nullptr) continue;
      curvature[i] = select(shifted[i] <= set.lower[i], penalty[i],
                            select(shifted[i] >= set.upper[i], penalty[i], S(0.0)));
      if (limited) curvature[i] = select(abs(outside) <= limit(i), curvature[i], S(0.0));
    }
  } else if (term.has_pairs()) {
    // The smaller one of a pair, whatever its multiplier, is the one that has to vanish.
    for (int i = 0; i < n; ++i) {
      const auto larger = i % 2 == 0 ? g[i] > g[i + 1] : g[i] >= g[i - 1];
      weight[i] = select(larger, min(shifted[i], S(0.0)), shifted[i]);
      if (curvature != nullptr)
        curvature[i] = select(larger, select(shifted[i] <= S(0.0), penalty[i], S(0.0)), penalty[i]);
    }
  } else {
    outside_cone(shifted, n, weight);
    if (curvature != nullptr) {
      outside_cone_derivative(shifted, n, curvature);
      if (limited) limit_cone_derivative(weight, n, limit(0), curvature);
      for (int i = 0; i < n * n; ++i) curvature[i] *= penalty[0];
    }
    // ½ p² up to the limit, from there on as steep as it is there: p·q − ½ q² with q cut off.
    for (int i = 0; i < n; ++i) shifted[i] = weight[i];
    if (limited) limit_cone(n, limit(0), weight);
    for (int i = 0; i < n; ++i) value += penalty[0] * weight[i] * (shifted[i] - S(0.5) * weight[i]);
  }
  for (int i = 0; i < n; ++i) {
    value += given.multiplier[i] * g[i];
    weight[i] = penalty[i] * weight[i] + given.multiplier[i];
  }
  return value;
}

}  // namespace conddp
