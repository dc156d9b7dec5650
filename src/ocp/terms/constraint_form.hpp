#pragma once

#include "ocp/terms/constraint.hpp"
#include "spatial/dual.hpp"

namespace conddp {

/// Keeps the derivative of ‖r‖ finite at r = 0.
inline constexpr double kSmallestNorm = 1e-12;

/// Computes g of a constraint from its residual's value. Returns the residual's norm for a norm
/// constraint, else 1.
template <class S>
S form_value(const ConstraintTerm& term, const S* r, S* g) {
  const int n = term.residual->size();
  S norm(1.0);
  if (term.kind == ConstraintKind::norm) {
    S sum(kSmallestNorm * kSmallestNorm);
    for (int i = 0; i < n; ++i) sum += r[i] * r[i];
    g[0] = norm = sqrt(sum);
  } else {
    for (int i = 0; i < n; ++i) g[i] = r[i];
    if (term.kind == ConstraintKind::second_order_cone) g[n - 1] = S(term.slope) * r[n - 1];
  }
  for (std::size_t i = 0; i < term.row_factors.size(); ++i) g[i] *= S(term.row_factors[i]);
  return norm;
}

namespace detail {

template <class S>
void form_norm_jacobian(const ConstraintTerm& term, const S* r, const S& norm, const S* residual,
                        S* jacobian) {
  const S inverse = S(1.0) / norm;
  for (const auto& [row, column] : term.entries)
    jacobian[column] += (r[row] * inverse) * *residual++;
}

template <class S>
void form_cone_jacobian(const ConstraintTerm& term, const S* residual, S* jacobian) {
  for (const auto& [row, column] : term.entries)
    jacobian[column * term.rows + row] = S(row == term.rows - 1 ? term.slope : 1.0) * *residual++;
}

template <class S>
void multiply_rows(const ConstraintTerm& term, S* jacobian) {
  const double* factors = term.row_factors.data();
  for (const RowBlock& block : term.blocks) {
    for (std::size_t c = 0; c < block.columns.size(); ++c)
      for (int i = 0; i < block.rows; ++i) *jacobian++ *= S(factors[i]);
    factors += block.rows;
  }
}

}  // namespace detail

/// Computes the blocks of ∂g/∂z from those of the residual.
template <class S>
void form_jacobian(const ConstraintTerm& term, const S* r, const S& norm, const S* residual,
                   S* jacobian) {
  if (term.kind == ConstraintKind::bounds || term.has_pairs()) {
    const int n = term.residual->jacobian_size();
    for (int i = 0; i < n; ++i) jacobian[i] = residual[i];
  } else {
    for (int i = 0; i < term.jacobian_size(); ++i) jacobian[i] = S(0.0);
    if (term.kind == ConstraintKind::norm)
      detail::form_norm_jacobian(term, r, norm, residual, jacobian);
    else
      detail::form_cone_jacobian(term, residual, jacobian);
  }
  if (!term.row_factors.empty()) detail::multiply_rows(term, jacobian);
}

}  // namespace conddp
