#include "solvers/constraints/row_side.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {
namespace {

/// A control this close to a bound is at the bound.
constexpr double kAtBound = 1e-9;
/// Tolerated violation by a step, relative to the bound.
constexpr double kViolated = 1e-10;

double distance(const NodeConstraint& c, const double* values) {
  return distance_to_set(*c.term, values, nullptr, nullptr);
}

/// Side of a row of bounds that a step brings back from beyond its limit.
RowSide back_inside(const NodeConstraint& c, int row, RowSide side) {
  return c.lower[row] == c.upper[row] ? RowSide::equality : side;
}

/// New side of an inactive row.
RowSide revised_inactive_bound(double value, double lower, double upper) {
  if (is_violated(lower - value, lower)) return RowSide::lower;
  return is_violated(value - upper, upper) ? RowSide::upper : RowSide::inactive;
}

/// New side of an active row. It stays if its multiplier still pushes, within its limit.
RowSide revised_active_bound(const NodeConstraint& c, RowSide side, double multiplier) {
  if (std::abs(multiplier) > c.limit) return multiplier < 0 ? RowSide::below : RowSide::above;
  if (side == RowSide::equality) return side;
  const bool pushes = side == RowSide::lower ? multiplier < 0 : multiplier > 0;
  return pushes ? side : RowSide::inactive;
}

bool is_cone_violated(const Eigen::Ref<const Eigen::VectorXd>& values) {
  const Eigen::Index m = values.size() - 1;
  const double outside = values.head(m).norm() - values[m];
  return !(outside <= kViolated * std::max(1.0, values.norm()));
}

/// Side of a cone that touches its boundary. The surface lacks a slope where the first `tangential`
/// values vanish.
RowSide touched_side(const double* values, Eigen::Index tangential) {
  const bool sloped = Eigen::Map<const Eigen::VectorXd>(values, tangential).squaredNorm() > 0;
  return sloped ? RowSide::surface : RowSide::tip;
}

/// Position of values relative to a second-order cone ‖v‖ ≤ t.
struct ConePoint {
  double length, height;  ///< ‖v‖ and t

  bool is_inside() const { return length <= height; }
  /// True if the tip is the nearest point of the cone.
  bool is_polar() const { return length <= -height; }
  double distance() const {
    return is_polar() ? std::hypot(length, height) : (length - height) * std::sqrt(0.5);
  }
};

/// Values plus multipliers/penalty.
ConePoint shifted_point(const double* values, const double* multipliers, double penalty, int rows) {
  double square = 0;
  for (int i = 0; i + 1 < rows; ++i) square += std::pow(values[i] + multipliers[i] / penalty, 2);
  return {std::sqrt(square), values[rows - 1] + multipliers[rows - 1] / penalty};
}

/// New side of an active cone, by whether its multipliers still push within their limit. `start`
/// holds the values at the iterate.
RowSide revised_active_cone(const NodeConstraint& c, RowSide side, const double* start,
                            const Eigen::Ref<const Eigen::VectorXd>& nu) {
  const Eigen::Index m = nu.size() - 1;
  if (nu.norm() > c.limit && distance(c, start) > 0) return RowSide::outside;
  if (side == RowSide::surface) return nu[m] < 0 ? side : RowSide::inactive;
  return nu.head(m).norm() <= -nu[m] ? side : touched_side(start, m);
}

}  // namespace

bool is_violated(double beyond, double bound) {
  return beyond > kViolated * std::max(1.0, std::abs(bound));
}

RowSide chosen_bound(const NodeConstraint& c, int row, double value, double multiplier,
                     double penalty) {
  const double outside = outside_bounds(value + multiplier / penalty, c.lower[row], c.upper[row]);
  if (std::abs(outside) > c.limit / penalty) return outside < 0 ? RowSide::below : RowSide::above;
  if (c.lower[row] == c.upper[row]) return RowSide::equality;
  if (outside < 0) return RowSide::lower;
  return outside > 0 ? RowSide::upper : RowSide::inactive;
}

void choose_pair(const double* values, const double* multipliers, const double* penalties,
                 RowSide* sides) {
  const int smaller = values[0] <= values[1] ? 0 : 1, larger = 1 - smaller;
  sides[smaller] = RowSide::equality;
  const double shifted = values[larger] + multipliers[larger] / penalties[larger];
  sides[larger] = shifted < 0 ? RowSide::lower : RowSide::inactive;
}

RowSide chosen_cone(const NodeConstraint& c, const double* values, const double* multipliers,
                    double penalty) {
  const int n = c.term->rows;
  const ConePoint shifted = shifted_point(values, multipliers, penalty, n);
  if (shifted.is_inside()) return RowSide::inactive;
  if (shifted.distance() > c.limit / penalty && distance(c, values) > 0) return RowSide::outside;
  return shifted.is_polar() ? RowSide::tip : touched_side(values, n - 1);
}

RowSide chosen_control(double control, double lower, double upper, double gradient) {
  const double below = control - lower, above = control - upper;
  if (below < 0 || (below <= kAtBound && gradient > 0)) return RowSide::lower;
  if (above > 0 || (above >= -kAtBound && gradient < 0)) return RowSide::upper;
  return RowSide::inactive;
}

RowSide revised_bound(const NodeConstraint& c, int row, RowSide side, double value,
                      double multiplier) {
  const double lower = c.lower[row], upper = c.upper[row];
  switch (side) {
    case RowSide::below:
      return value <= lower ? side : back_inside(c, row, RowSide::lower);
    case RowSide::above:
      return value >= upper ? side : back_inside(c, row, RowSide::upper);
    case RowSide::inactive:
      return revised_inactive_bound(value, lower, upper);
    default:
      return revised_active_bound(c, side, multiplier);
  }
}

RowSide revised_cone(const NodeConstraint& c, RowSide side, const double* start,
                     const Eigen::Ref<const Eigen::VectorXd>& values,
                     const Eigen::Ref<const Eigen::VectorXd>& nu) {
  const RowSide touched = touched_side(start, nu.size() - 1);
  if (side == RowSide::inactive) return is_cone_violated(values) ? touched : side;
  if (side == RowSide::outside) return distance(c, values.data()) > 0 ? side : touched;
  return revised_active_cone(c, side, start, nu);
}

}  // namespace conddp
