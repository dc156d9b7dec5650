// The rows of Newton's method: equations that the multipliers enforce.
#include <algorithm>
#include <cmath>
#include <limits>

#include "ocp/terms/constraint.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/constraints/horizon_rows.hpp"

namespace conddp {

void HorizonRows::choose(const Linearization& linearization, const Eigen::VectorXd& penalty,
                         Eigen::VectorXd& multipliers) {
  value_.head(controls_) = linearization.constraint;
  for (const NodeConstraint& c : problem_.constraints())
    for (int r = 0; c.term->has_pairs() && r < c.term->rows; ++r) {
      const int row = c.row + r, other = c.row + (r ^ 1);
      const bool smaller =
          value_[row] < value_[other] || (value_[row] == value_[other] && row < other);
      own_lower_[row] = 0;
      own_upper_[row] = smaller ? 0 : std::numeric_limits<double>::infinity();
    }
  measure_bounds();
  for (std::size_t i = 0; i < problem_.constraints().size(); ++i) {
    Term& c = terms_[i];
    if (c.cone)
      choose_cone(c, penalty[c.row], multipliers.data() + c.row);
    else
      choose_bounds(c, penalty.data() + c.row, multipliers.data() + c.row);
  }
}

void HorizonRows::choose_bounds(const Term& c, const double* penalty, double* multipliers) {
  for (int r = 0; r < c.count; ++r) {
    const int row = c.row + r;
    const double lower = lower_[row], upper = upper_[row], s = multipliers[r] / penalty[r];
    const double outside = outside_bounds(s, lower, upper);
    const double limit = own_limit_[row];
    const bool beyond = std::abs(outside) > limit / penalty[r];
    slope_[row] = !beyond && (outside != 0 || lower == upper);
    offset_[row] = -std::clamp(s, lower, upper);
    if (beyond) multipliers[r] = std::copysign(limit, outside);
    if (!beyond && slope_[row] == 0) multipliers[r] = 0;
  }
}

void HorizonRows::choose_cone(Term& c, double penalty, double* multipliers) {
  const int n = c.count;
  Eigen::Map<Eigen::VectorXd> nu(multipliers, n);
  auto s = point_.head(n), outside = scratch_.head(n);
  s = value_.segment(c.row, n) + nu / penalty;
  outside_cone(s.data(), n, outside.data());
  const double* values = value_.data() + c.row;
  const double limit = own_limit_[c.row];
  if ((outside.array() == 0).all()) {
    c.side = ConeSide::inside;
    nu.setZero();
  } else if (outside.norm() > limit / penalty && distance(c, values) > 0) {
    c.side = ConeSide::outside;
    outside_cone(values, n, outside.data());
    nu = (limit / outside.norm()) * outside;
  } else {
    c.side = outside == s ? ConeSide::tip : touched_side(c);
    if (c.side == ConeSide::surface) {
      const double push = std::max(0.0, -nu[n - 1]), length = value_.segment(c.row, n - 1).norm();
      nu.head(n - 1) = (push / length) * value_.segment(c.row, n - 1);
      nu[n - 1] = -push;
    }
  }
}

double HorizonRows::distance(const Term& c, const double* values) const {
  return distance_to_set(*problem_.constraints()[term_[c.row]].term, values, nullptr, nullptr);
}

/// Side of a cone that touches its boundary: the surface, or the tip if the iterate lies on the
/// cone's axis, where the surface lacks a slope.
HorizonRows::ConeSide HorizonRows::touched_side(const Term& c) const {
  return (value_.segment(c.row, c.count - 1).array() == 0).all() ? ConeSide::tip
                                                                 : ConeSide::surface;
}

double HorizonRows::impose(const Eigen::VectorXd& multipliers, double penalty,
                           Linearization& linearization) {
  penalty_.head(controls_).setConstant(penalty);
  base_.head(controls_) = multipliers / penalty;
  measure_limits();
  double largest = 0;
  for (int k = 0; k <= problem_.knots(); ++k) {
    KnotLinearization& knot = linearization.knots[k];
    for (const int i : nodes_[k].terms) {
      const Term& c = terms_[i];
      if (c.kind != Kind::constraint) continue;
      if (c.cone) {
        offset_.segment(c.row, c.count).setZero();
        cone_slope_[i].setZero();
        model_cone(i);
        set_cone(i, knot);
      } else {
        impose_bounds(c, knot);
      }
      shifted_.segment(c.row, c.count) = base_.segment(c.row, c.count);
      if (find_corrections(i))
        largest = std::max(largest, new_base_.head(c.count).lpNorm<Eigen::Infinity>());
    }
    if (!update_.empty()) update_.apply(knot.hessian);
  }
  return largest;
}

void HorizonRows::impose_bounds(const Term& c, KnotLinearization& knot) {
  for (int row = c.row; row < c.row + c.count; ++row) {
    const double slope = slope_[row], offset = slope == 1 ? offset_[row] : base_[row];
    offset_[row] = slope_[row] = 0;
    set_row(c, row, offset, slope, base_[row], knot);
  }
}

int HorizonRows::revise_active(const std::vector<Eigen::VectorXd>& z,
                               Linearization& linearization) {
  shift(z, linearization, shifted_);
  int changes = 0;
  for (int k = 0; k <= problem_.knots(); ++k) {
    KnotLinearization& knot = linearization.knots[k];
    for (const int i : nodes_[k].terms)
      if (terms_[i].kind == Kind::constraint)
        changes +=
            terms_[i].cone ? revise_active_cone(i, knot) : revise_active_bounds(terms_[i], knot);
    if (!update_.empty()) update_.apply(knot.hessian);
  }
  return changes;
}

bool HorizonRows::revise_active_bounds(const Term& c, KnotLinearization& knot) {
  bool changed = false;
  for (int row = c.row; row < c.row + c.count; ++row) {
    const double s = shifted_[row], found = outside(row, s);
    const bool active = slope_[row] != 0 || offset_[row] != 0;
    const double allowed = active ? 0 : tuning::kExact * std::max(1.0, std::abs(value_[row] + s));
    if (std::abs(found - model(row, s)) <= allowed) continue;
    double offset, slope;
    model_row(row, s, true, offset, slope);
    set_row(c, row, offset, slope, slope == 1 ? base_[row] : offset, knot);
    changed = true;
  }
  return changed;
}

bool HorizonRows::revise_active_cone(int term, KnotLinearization& knot) {
  const ConeSide side = revised_side(term);
  if (side == terms_[term].side) return false;
  terms_[term].side = side;
  model_cone(term);
  set_cone(term, knot);
  return true;
}

HorizonRows::ConeSide HorizonRows::revised_side(int term) {
  const Term& c = terms_[term];
  const int n = c.count;
  const auto s = shifted_.segment(c.row, n);
  auto values = point_.head(n), P = scratch_.head(n);
  values = value_.segment(c.row, n) + s - base_.segment(c.row, n);
  P = offset_.segment(c.row, n);
  P.noalias() += cone_slope_[term] * s;
  const ConeSide touched = touched_side(c);
  switch (c.side) {
    case ConeSide::inside: {
      const double beyond = values.head(n - 1).norm() - values[n - 1];
      return beyond > tuning::kExact * std::max(1.0, values.norm()) ? touched : c.side;
    }
    case ConeSide::outside:
      return distance(c, values.data()) > 0 ? c.side : touched;
    default:
      if (P.norm() > limit_[c.row] && distance(c, value_.data() + c.row) > 0)
        return ConeSide::outside;
      if (c.side == ConeSide::surface) return P[n - 1] < 0 ? c.side : ConeSide::inside;
      return P.head(n - 1).norm() <= -P[n - 1] ? c.side : touched;
  }
}

/// new_offset_, new_slope_, new_base_ ← a, S and ν/ρ of a cone, by its side. At values (v, t), the
/// surface is the row ‖v‖ − t with the derivative n = (v/‖v‖, −1). There S is ½ n nᵀ plus the
/// curvature of ‖v‖, times the multiplier over ρ.
void HorizonRows::model_cone(int term) {
  const Term& c = terms_[term];
  const int n = c.count;
  const auto g = value_.segment(c.row, n), base = base_.segment(c.row, n);
  auto offset = new_offset_.head(n), new_base = new_base_.head(n);
  Eigen::Map<Eigen::MatrixXd> slope(new_slope_.data(), n, n);
  offset.setZero();
  slope.setZero();
  new_base.setZero();
  if (c.side == ConeSide::tip) {
    offset = g;
    slope.setIdentity();
    new_base = base;
  } else if (c.side == ConeSide::surface) {
    find_normal(c);
    const auto normal = scratch_.head(n);
    const double length = g.head(n - 1).norm(), push = std::max(0.0, -base[n - 1]);
    offset = 0.5 * (length - g[n - 1]) * normal;
    new_base = push * normal;
    slope.diagonal().head(n - 1).setConstant(push / length);
    slope.topLeftCorner(n - 1, n - 1).noalias() -=
        (push / length) * normal.head(n - 1) * normal.head(n - 1).transpose();
    slope.noalias() += 0.5 * normal * normal.transpose();
  } else if (c.side == ConeSide::outside) {
    outside_cone(g.data(), n, offset.data());
    outside_cone_derivative(g.data(), n, slope.data());
    const double distance = offset.norm(), limit = limit_[c.row];
    offset /= distance;
    slope.noalias() -= offset * offset.transpose();
    slope *= limit / distance;
    offset *= limit;
    new_base = offset;
  }
}

/// new_base_ ← the change of ν/ρ in the active rows of a term, which is their residual. False
/// without active rows.
bool HorizonRows::find_corrections(int term) {
  const Term& c = terms_[term];
  const int n = c.count;
  auto change = new_base_.head(n);
  change = offset_.segment(c.row, n) + shifted_.segment(c.row, n) - base_.segment(c.row, n);
  if (!c.cone) {
    const auto slope = slope_.segment(c.row, n);
    change = change.cwiseProduct(slope);
    return (slope.array() != 0).any();
  }
  if (c.side != ConeSide::surface) return c.side == ConeSide::tip;
  find_normal(c);
  const auto normal = scratch_.head(n);
  const double off = normal.dot(change);
  change = 0.5 * off * normal;
  return true;
}

/// scratch_ ← the derivative of ‖v‖ − t at the iterate's values (v, t) of a cone.
void HorizonRows::find_normal(const Term& c) {
  auto normal = scratch_.head(c.count);
  normal = value_.segment(c.row, c.count);
  normal /= normal.head(c.count - 1).norm();
  normal[c.count - 1] = -1;
}

double HorizonRows::correct(const std::vector<Eigen::VectorXd>& z, Linearization& linearization) {
  shift(z, linearization, shifted_);
  double largest = 0;
  for (std::size_t i = 0; i < problem_.constraints().size(); ++i) {
    if (!find_corrections(static_cast<int>(i))) continue;
    const Term& c = terms_[i];
    const auto change = new_base_.head(c.count);
    largest = std::max(largest, change.lpNorm<Eigen::Infinity>());
    base_.segment(c.row, c.count) += change;
    KnotLinearization& knot = linearization.knots[c.node];
    knot.gradient.noalias() += penalty_[c.row] * (jacobian(c, knot).transpose() * change);
  }
  return largest;
}

void HorizonRows::write_multipliers(Eigen::VectorXd& multipliers) const {
  multipliers = penalty_.head(controls_).cwiseProduct(base_.head(controls_));
}

int HorizonRows::active_rows() const {
  int count = 0;
  for (const Term& c : terms_) {
    if (c.kind != Kind::constraint) continue;
    if (!c.cone)
      count += static_cast<int>((slope_.segment(c.row, c.count).array() != 0).count());
    else if (c.side == ConeSide::surface || c.side == ConeSide::tip)
      count += c.side == ConeSide::surface ? 1 : c.count;
  }
  return count;
}

}  // namespace conddp
