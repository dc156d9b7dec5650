#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ocp/terms/free_duration.hpp"
#include "ocp/terms/residual.hpp"

namespace conddp {

/// The set in which the value g of a constraint has to lie:
/// - bounds: lower ≤ g ≤ upper row by row, where g is the residual; equal bounds are an equality;
/// - norm: lower ≤ ‖r‖ ≤ upper, where r is the residual; g = ‖r‖ is one row;
/// - second_order_cone: ‖(g_0, …, g_{n−2})‖ ≤ g_{n−1}, where g is the residual with its last row
///   times `slope`;
/// - complementarity: 0 ≤ g_{2i} ⊥ g_{2i+1} ≥ 0 for each pair of rows, where g is the residual,
/// each
///   row of which is one entry of the control.
enum class ConstraintKind { bounds, norm, second_order_cone, complementarity };

/// What happens where a constraint does not hold:
/// - hard: it has to hold at a solution;
/// - l1: it costs its weight times the distance from the set (rows of bounds one by one, the norm
///   of a cone's). That is exact: as long as multipliers stay below the weight it holds like a hard
///   one. Solvers see a constraint whose multipliers the weight limits;
/// - l2: it costs half the weight times the square of the distance. That is a cost, and smooth.
/// Both are multiplied by the knot's cost scale, as all costs are.
enum class Softness { hard, l1, l2 };

/// A constraint of a knot model. Its numbers in a knot's parameters, in this order: the residual's
/// parameters; lower and upper bounds, a number per row each (not of cones and pairs); a switch
/// that is 0 where the constraint is left out and 1 elsewhere; of a soft one its weight.
struct ConstraintTerm {
  std::string name;
  std::shared_ptr<const Residual> residual;
  ConstraintKind kind = ConstraintKind::bounds;
  double slope = 1;  ///< of a cone
  /// What the rows of g are multiplied by, of cones all alike; empty: by nothing.
  std::vector<double> row_factors = {};
  Softness softness = Softness::hard;
  /// Duration with which the cost of a soft constraint grows.
  std::optional<FreeDuration> grows_with = {};
  /// True if the rows of an l1-soft constraint grow in place of its weight.
  bool by_duration = false;
  std::vector<RowBlock> blocks;  ///< the structure of ∂g/∂z
  int rows = 0;
  int row = 0;         ///< its first row among the constraint rows of the knot
  int jacobian = 0;    ///< where its entries start among those of ∂g/∂z of the knot
  int parameters = 0;  ///< where its numbers start in the knot's parameters
  /// For each entry of the residual's packed Jacobian its row and, among the columns of the one
  /// block of a norm or cone, its column.
  std::vector<std::pair<int, int>> entries;

  bool has_bounds() const { return kind == ConstraintKind::bounds || kind == ConstraintKind::norm; }
  bool is_cone() const { return kind == ConstraintKind::second_order_cone; }
  bool has_pairs() const { return kind == ConstraintKind::complementarity; }
  /// Where bounds and switch start in the knot's parameters.
  int lower() const { return parameters + residual->parameter_count(); }
  int upper() const { return lower() + rows; }
  int active() const { return lower() + (has_bounds() ? 2 * rows : 0); }
  int weight() const { return active() + 1; }
  int parameter_end() const { return active() + (softness == Softness::hard ? 1 : 2); }
  /// Whether g depends on the control of a node with ndx tangent coordinates.
  bool depends_on_control(int ndx) const;
  /// Numbers in the packed ∂g/∂z.
  int jacobian_size() const;
};

/// Without row and column offsets, which belong to the model. Throws std::invalid_argument where a
/// cone has fewer than two rows or the slope is not positive, or complementary rows are no pairs of
/// single columns.
ConstraintTerm make_constraint(std::string name, std::shared_ptr<const Residual> residual,
                               ConstraintKind kind, double slope = 1,
                               Softness softness = Softness::hard);

/// s − the point of [lower, upper] nearest to s.
template <class S>
S outside_bounds(const S& s, const S& lower, const S& upper) {
  return s - max(lower, min(upper, s));
}

/// p = s − the point of the second-order cone nearest to s, which is the projection of s on the
/// polar cone {(v, t): ‖v‖ ≤ −t}. n rows, at least 2.
template <class S>
void outside_cone(const S* s, int n, S* p);

/// The derivative of outside_cone, n x n and symmetric, positive semidefinite; at a kink one of
/// the two sides.
template <class S>
void outside_cone_derivative(const S* s, int n, S* derivative);

/// How far values are from the set of a constraint: ∞-norm of outside_bounds, ‖outside_cone‖,
/// largest |min(z, s)| of pairs.
/// `values`, and the bounds if it has any, hold `rows` numbers.
double distance_to_set(const ConstraintTerm& term, const double* values, const double* lower,
                       const double* upper);

/// |ν (g − bound)| of a row inside its bounds, with the bound that the sign of its multiplier ν
/// names (upper if positive); |ν| where that is infinite, 0 where both bounds are one.
double bound_complementarity(double value, double lower, double upper, double multiplier);

/// How far the multipliers of a cone's n rows are from the polar cone.
double distance_to_polar_cone(const double* multipliers, int n);

/// Whether multipliers and values are complementary: largest |ν_i (g_i − bound)|, with the bound
/// that ν_i's sign names (upper if positive), where g lies inside and bounds differ; |νᵀg| of a
/// cone; |ν_i g_i| of a pair's larger one (the second of equals). Signs of infinite bounds count
/// |ν_i|, the part of ν outside of the polar cone its norm.
double complementarity(const ConstraintTerm& term, const double* values, const double* lower,
                       const double* upper, const double* multipliers);

}  // namespace conddp
