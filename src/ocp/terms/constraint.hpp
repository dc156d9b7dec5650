#pragma once

#include <compare>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ocp/terms/residual.hpp"
#include "spatial/dual.hpp"

namespace conddp {

/// Free duration of a phase: a held number of the state, s. It scales the time steps of the phase,
/// and the costs that grow with it, by its ratio to the written duration.
struct FreeDuration {
  int choice;      ///< index among the held numbers
  double written;  ///< s

  auto operator<=>(const FreeDuration&) const = default;
};

/// Set of admissible values g of a constraint:
/// - bounds: lower ≤ g ≤ upper row by row, where g is the residual; equal bounds form an equality;
/// - norm: lower ≤ ‖r‖ ≤ upper, where r is the residual; g = ‖r‖ is one row;
/// - second_order_cone: ‖(g_0, …, g_{n−2})‖ ≤ g_{n−1}, where g is the residual with its last row
///   times `slope`;
/// - complementarity: 0 ≤ g_{2i} ⊥ g_{2i+1} ≥ 0 for each pair of rows, where g is the residual and
///   each row is one entry of the control.
enum class ConstraintKind { bounds, norm, second_order_cone, complementarity };

/// Treatment of a violated constraint:
/// - hard: the constraint must hold at a solution;
/// - l1: costs its weight times the distance from the set (row by row for bounds, the norm for a
///   cone). This penalty is exact: the constraint holds like a hard one as long as its multipliers
///   stay below the weight. Solvers see a constraint whose multipliers are limited by the weight;
/// - l2: costs half the weight times the squared distance, a smooth cost.
/// The knot's cost scale multiplies both penalties, as it does all costs.
enum class Softness { hard, l1, l2 };

/// A constraint of a knot model. Its numbers in a knot's parameters begin with the residual's
/// parameters, then lower and upper bounds (one number per row each, not for cones and pairs). A
/// switch (0 if the constraint is omitted, else 1) and the weight of a soft constraint follow.
struct ConstraintTerm {
  std::string name;
  std::shared_ptr<const Residual> residual;
  ConstraintKind kind = ConstraintKind::bounds;
  double slope = 1;  ///< of a cone
  /// Factors on the rows of g, all equal for a cone; empty if all are 1.
  std::vector<double> row_factors = {};
  Softness softness = Softness::hard;
  /// Free duration that scales the cost of a soft constraint.
  std::optional<FreeDuration> grows_with = {};
  /// True if the duration scales the rows of an l1-soft constraint instead of its weight.
  bool by_duration = false;
  std::vector<RowBlock> blocks;  ///< the structure of ∂g/∂z
  int rows = 0;
  int row = 0;         ///< first row among the constraint rows of the knot
  int jacobian = 0;    ///< start of its entries among those of ∂g/∂z of the knot
  int parameters = 0;  ///< start of its numbers in the knot's parameters
  /// For each entry of the residual's packed Jacobian: its row, and its column among those of the
  /// single block of a norm or cone.
  std::vector<std::pair<int, int>> entries;

  bool has_bounds() const { return kind == ConstraintKind::bounds || kind == ConstraintKind::norm; }
  bool is_cone() const { return kind == ConstraintKind::second_order_cone; }
  bool has_pairs() const { return kind == ConstraintKind::complementarity; }
  /// Start of bounds, switch and weight in the knot's parameters.
  int lower() const { return parameters + residual->parameter_count(); }
  int upper() const { return lower() + rows; }
  int active() const { return lower() + (has_bounds() ? 2 * rows : 0); }
  int weight() const { return active() + 1; }
  int parameter_end() const { return active() + (softness == Softness::hard ? 1 : 2); }
  /// True if g depends on the control of a node with ndx tangent coordinates.
  bool depends_on_control(int ndx) const;
  /// Number of entries in the packed ∂g/∂z.
  int jacobian_size() const;
};

/// Makes a constraint without row and column offsets, which belong to the model. Throws
/// std::invalid_argument if a cone has fewer than two rows or its slope is not positive, or if
/// complementary rows are not pairs of single columns.
ConstraintTerm make_constraint(std::string name, std::shared_ptr<const Residual> residual,
                               ConstraintKind kind, double slope = 1,
                               Softness softness = Softness::hard);

/// s minus its projection on [lower, upper].
template <class S>
S outside_bounds(const S& s, const S& lower, const S& upper) {
  return s - max(lower, min(upper, s));
}

/// p = s minus its projection on the second-order cone, which is the projection of s on the polar
/// cone {(v, t): ‖v‖ ≤ −t}. n rows, at least 2.
template <class S>
void outside_cone(const S* s, int n, S* p);

/// The derivative of outside_cone: n x n, symmetric, positive semidefinite; one-sided at a kink.
template <class S>
void outside_cone_derivative(const S* s, int n, S* derivative);

/// Distance of values from the set of a constraint: ∞-norm of outside_bounds, ‖outside_cone‖, or
/// the largest |min(z, s)| of pairs. `values`, and bounds if any, have `rows` numbers.
double distance_to_set(const ConstraintTerm& term, const double* values, const double* lower,
                       const double* upper);

/// |ν (g − bound)| of a row inside its bounds. The sign of its multiplier ν selects the bound
/// (upper if positive). The result is |ν| if that bound is infinite, and 0 if both bounds are
/// equal.
double bound_complementarity(double value, double lower, double upper, double multiplier);

/// Distance of the multipliers of a cone's n rows from the polar cone.
double distance_to_polar_cone(const double* multipliers, int n);

/// Complementarity of multipliers and values. Bounds: the largest bound_complementarity() of a row.
/// Cone: the larger of |νᵀg| and the distance of ν from the polar cone. Pairs: the largest |ν_i
/// g_i|, where i is the larger value of a pair (the second if equal).
double complementarity(const ConstraintTerm& term, const double* values, const double* lower,
                       const double* upper, const double* multipliers);

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
