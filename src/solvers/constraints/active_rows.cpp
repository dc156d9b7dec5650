#include "solvers/constraints/active_rows.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {
namespace {

/// A control this close to a bound stands there.
constexpr double kAtBound = 1e-9;
/// What a step may violate, relative to the bound, without its counting.
constexpr double kViolated = 1e-10;

}  // namespace

ActiveRows::ActiveRows(const ShootingProblem& problem, const ControlBounds& bounds)
    : problem_(problem),
      bounds_(bounds),
      rows_(problem.knots() + 1),
      constraints_of_(problem.knots() + 1),
      sides_(problem.constraint_rows(), kInactive),
      control_sides_(bounds.size(), kInactive),
      target_(Eigen::VectorXd::Zero(problem.constraint_rows())) {
  for (std::size_t i = 0; i < problem.constraints().size(); ++i)
    constraints_of_[problem.constraints()[i].node].push_back(static_cast<int>(i));
  int largest = 0, most = 0;
  for (int k = 0; k <= problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    const int m = model.constraint_rows() + model.nu();
    Rows& rows = rows_[k];
    rows.A = Eigen::MatrixXd::Zero(m, model.nz());
    for (Eigen::VectorXd* v : {&rows.value, &rows.multiplier, &rows.correction})
      *v = Eigen::VectorXd::Zero(m);
    rows.source.resize(m);
    rows.constraint.resize(m);
    rows.kind.resize(m);
    largest = std::max(largest, model.nz());
    most = std::max(most, m);
  }
  scratch_.resize(largest);
  int cone = 0;
  for (const NodeConstraint& c : problem.constraints())
    if (c.is_soft() && !c.term->has_bounds()) cone = std::max(cone, c.term->rows);
  slope_.resize(cone, cone);
  product_.resize(cone, largest);
  predicted_.resize(most);
}

void ActiveRows::choose(const Linearization& linearization, const Eigen::VectorXd& penalty,
                        Eigen::VectorXd& multipliers) {
  for (const NodeConstraint& c : problem_.constraints()) {
    const double* g = linearization.constraint.data() + c.row;
    const double* nu = multipliers.data() + c.row;
    const int n = c.term->rows;
    if (c.term->has_bounds()) {
      for (int i = 0; i < n; ++i) {
        const double outside =
            outside_bounds(g[i] + nu[i] / penalty[c.row + i], c.lower[i], c.upper[i]);
        sides_[c.row + i] = std::abs(outside) > c.limit / penalty[c.row + i]
                                ? (outside < 0 ? kBelow : kAbove)
                            : c.lower[i] == c.upper[i] ? kEquality
                            : outside < 0              ? kLower
                            : outside > 0              ? kUpper
                                                       : kInactive;
      }
      continue;
    }
    if (c.term->has_pairs()) {
      // Both count where both vanish and the larger one's multiplier pushes it below zero.
      for (int i = 0; i < n; i += 2) {
        const int smaller = g[i] <= g[i + 1] ? i : i + 1, larger = 2 * i + 1 - smaller;
        sides_[c.row + smaller] = kEquality;
        sides_[c.row + larger] =
            g[larger] + nu[larger] / penalty[c.row + larger] < 0 ? kLower : kInactive;
      }
      continue;
    }
    double square = 0, length = 0;
    for (int i = 0; i + 1 < n; ++i) {
      square += std::pow(g[i] + nu[i] / penalty[c.row], 2);
      length += g[i] * g[i];
    }
    const double a = std::sqrt(square), t = g[n - 1] + nu[n - 1] / penalty[c.row];
    sides_[c.row] = a <= t ? kInactive : a <= -t || length == 0 ? kTip : kSurface;
    if (!c.is_soft() || sides_[c.row] == kInactive) continue;
    const double outside = a <= -t ? std::hypot(a, t) : (a - t) * std::sqrt(0.5);
    const double limit = c.limit / penalty[c.row];
    if (outside > limit && distance_to_set(*c.term, g, nullptr, nullptr) > 0)
      sides_[c.row] = kOutside;
  }
  for (int k = 0; k <= problem_.knots(); ++k) build(k, linearization, multipliers);
  write_multipliers(linearization, false, multipliers);
}

void ActiveRows::choose_controls(const Trajectory& trajectory, const Adjoint& adjoint) {
  for (int k = 0; k < problem_.knots(); ++k) {
    const auto u = trajectory.u(k);
    for (int i = 0; i < u.size(); ++i) {
      const double gradient = adjoint.gradient()[bounds_.offset(k) + i];
      const double below = u[i] - bounds_.lower(k)[i], above = u[i] - bounds_.upper(k)[i];
      const bool at_lower = below < 0 || (below <= kAtBound && gradient > 0);
      const bool at_upper = above > 0 || (above >= -kAtBound && gradient < 0);
      control_sides_[bounds_.offset(k) + i] = at_lower ? kLower : at_upper ? kUpper : kInactive;
    }
    build_controls(k, trajectory, adjoint);
  }
}

ActiveRows::Side ActiveRows::revised_bound(const NodeConstraint& c, int i, double value,
                                           double multiplier) {
  const Side side = sides_[c.row + i];
  if (side == kBelow) return value <= c.lower[i] ? kBelow : back_inside(c, i, kLower);
  if (side == kAbove) return value >= c.upper[i] ? kAbove : back_inside(c, i, kUpper);
  if (side != kInactive && std::abs(multiplier) > c.limit) return multiplier < 0 ? kBelow : kAbove;
  if (side == kEquality) return side;
  if (side == kLower) return multiplier < 0 ? kLower : kInactive;
  if (side == kUpper) return multiplier > 0 ? kUpper : kInactive;
  const auto beyond = [](double by, double bound) {
    return by > kViolated * std::max(1.0, std::abs(bound));
  };
  if (beyond(c.lower[i] - value, c.lower[i])) return kLower;
  return beyond(value - c.upper[i], c.upper[i]) ? kUpper : kInactive;
}

ActiveRows::Side ActiveRows::revised_cone(const NodeConstraint& c,
                                          const Linearization& linearization,
                                          const Eigen::Ref<const Eigen::VectorXd>& values) const {
  const int n = c.term->rows;
  const auto nu = target_.segment(c.row, n);
  const bool sloped = linearization.constraint.segment(c.row, n - 1).squaredNorm() > 0;
  if (c.is_soft()) {
    const auto distance = [&](const double* s) {
      return distance_to_set(*c.term, s, nullptr, nullptr);
    };
    if (sides_[c.row] == kOutside && distance(values.data()) > 0) return kOutside;
    if (sides_[c.row] == kOutside) return sloped ? kSurface : kTip;
    const bool here = distance(linearization.constraint.data() + c.row) > 0;
    if (sides_[c.row] != kInactive && nu.norm() > c.limit && here) return kOutside;
  }
  if (sides_[c.row] == kSurface) return nu[n - 1] < 0 ? kSurface : kInactive;
  if (sides_[c.row] == kTip) {
    if (nu.head(n - 1).norm() <= -nu[n - 1] || !sloped) return kTip;
    return kSurface;
  }
  const double outside = values.head(n - 1).norm() - values[n - 1];
  if (outside <= kViolated * std::max(1.0, values.norm())) return kInactive;
  return sloped ? kSurface : kTip;
}

bool ActiveRows::revise(const Linearization& linearization, const Trajectory& trajectory,
                        const Adjoint& adjoint, const Eigen::VectorXd& multipliers,
                        const std::vector<Eigen::VectorXd>& step) {
  write_multipliers(linearization, true, target_);
  bool changed = false;
  const auto set = [&](Side& side, Side now) {
    changed |= side != now;
    side = now;
  };
  for (int k = 0; k <= problem_.knots(); ++k) {
    const int offset = problem_.constraint_offset(k);
    for (const int index : constraints_of_[k]) {
      const NodeConstraint& c = problem_.constraints()[index];
      const int n = c.term->rows;
      auto values = predicted_.head(n);
      values = linearization.constraint.segment(c.row, n);
      values.noalias() += linearization.knots[k].C.middleRows(c.row - offset, n) * step[k];
      if (c.term->has_pairs()) {
        for (int i = 0; i < n; ++i) {
          Side& side = sides_[c.row + i];
          if (side == kLower && target_[c.row + i] >= 0) set(side, kInactive);
          if (side == kInactive && values[i] < -kViolated) set(side, kLower);
        }
        continue;
      }
      if (c.term->is_cone()) {
        set(sides_[c.row], revised_cone(c, linearization, values));
        continue;
      }
      for (int i = 0; i < n; ++i)
        set(sides_[c.row + i], revised_bound(c, i, values[i], target_[c.row + i]));
    }
    if (k == problem_.knots()) break;
    const Rows& rows = rows_[k];
    const auto u = trajectory.u(k);
    const auto du = step[k].tail(u.size());
    for (int i = 0; i < u.size(); ++i) {
      Side& side = control_sides_[bounds_.offset(k) + i];
      if (side != kInactive) continue;
      const double lower = bounds_.lower(k)[i], upper = bounds_.upper(k)[i];
      if (lower - u[i] - du[i] > kViolated * std::max(1.0, std::abs(lower))) set(side, kLower);
      if (u[i] + du[i] - upper > kViolated * std::max(1.0, std::abs(upper))) set(side, kUpper);
    }
    for (int r = 0; r < rows.count; ++r) {
      if (rows.kind[r] != kControl) continue;
      Side& side = control_sides_[bounds_.offset(k) + rows.source[r]];
      const double multiplier = rows.multiplier[r] + rows.correction[r];
      if (side == kLower ? multiplier > 0 : multiplier < 0) set(side, kInactive);
    }
  }
  if (!changed) return false;
  for (int k = 0; k <= problem_.knots(); ++k) {
    build(k, linearization, multipliers);
    if (k < problem_.knots()) build_controls(k, trajectory, adjoint);
  }
  return true;
}

void ActiveRows::add_row(Rows& rows, Kind kind, int source, int constraint, double value,
                         double multiplier) {
  rows.kind[rows.count] = kind;
  rows.source[rows.count] = source;
  rows.constraint[rows.count] = constraint;
  rows.value[rows.count] = value;
  rows.multiplier[rows.count] = multiplier;
  rows.correction[rows.count++] = 0;
}

/// The rows of a node's constraints; those of its controls come after them.
void ActiveRows::build(int node, const Linearization& linearization,
                       const Eigen::VectorXd& multipliers) {
  Rows& rows = rows_[node];
  const int offset = problem_.constraint_offset(node);
  rows.count = 0;
  for (const int index : constraints_of_[node]) {
    const NodeConstraint& c = problem_.constraints()[index];
    const int n = c.term->rows;
    const auto C = linearization.knots[node].C.middleRows(c.row - offset, n);
    const auto g = linearization.constraint.segment(c.row, n);
    if (c.term->is_cone() && sides_[c.row] == kInactive) continue;
    if (c.term->is_cone() && sides_[c.row] == kOutside) {
      build_outside(rows, index, linearization);
      continue;
    }
    if (c.term->is_cone() && sides_[c.row] == kSurface) {
      const double length = g.head(n - 1).norm();
      auto row = rows.A.row(rows.count);
      row = -C.row(n - 1);
      for (int i = 0; i + 1 < n; ++i) row += (g[i] / length) * C.row(i);
      add_row(rows, kConeSurface, c.row, index, length - g[n - 1],
              std::max(0.0, -multipliers[c.row + n - 1]));
      continue;
    }
    for (int i = 0; i < n; ++i) {
      const bool tip = c.term->is_cone();
      const Side side = sides_[c.row + i];
      if (!tip && side == kInactive) continue;
      rows.A.row(rows.count) = C.row(i);
      if (side == kBelow || side == kAbove) {
        add_row(rows, kLimit, c.row + i, index, 0, side == kBelow ? -c.limit : c.limit);
        continue;
      }
      const double bound = !c.term->has_bounds() ? 0 : side == kUpper ? c.upper[i] : c.lower[i];
      add_row(rows, tip ? kConeTip : kBounds, c.row + i, index, g[i] - bound,
              multipliers[c.row + i]);
    }
  }
}

/// A soft cone that does not hold pushes with all it has, straight towards itself.
void ActiveRows::build_outside(Rows& rows, int index, const Linearization& linearization) {
  const NodeConstraint& c = problem_.constraints()[index];
  const int n = c.term->rows, offset = problem_.constraint_offset(c.node);
  auto push = predicted_.head(n);
  outside_cone(linearization.constraint.data() + c.row, n, push.data());
  push *= c.limit / push.norm();
  for (int i = 0; i < n; ++i) {
    rows.A.row(rows.count) = linearization.knots[c.node].C.row(c.row - offset + i);
    add_row(rows, kLimit, c.row + i, index, 0, push[i]);
  }
}

/// Its curvature: that of the distance, times the limit.
void ActiveRows::add_outside_curvature(int index, KnotLinearization& knot,
                                       const Eigen::VectorXd& values) {
  const NodeConstraint& c = problem_.constraints()[index];
  const int n = c.term->rows;
  auto p = predicted_.head(n);
  outside_cone(values.data() + c.row, n, p.data());
  Eigen::Map<Eigen::MatrixXd> slope(slope_.data(), n, n);
  outside_cone_derivative(values.data() + c.row, n, slope.data());
  const double distance = p.norm();
  p /= distance;
  slope.noalias() -= p * p.transpose();
  slope *= c.limit / distance;
  const auto C = knot.C.middleRows(c.row - problem_.constraint_offset(c.node), n);
  auto product = product_.topLeftCorner(n, C.cols());
  product.noalias() = slope * C;
  knot.hessian.change().noalias() += C.transpose() * product;
}

void ActiveRows::build_controls(int node, const Trajectory& trajectory, const Adjoint& adjoint) {
  Rows& rows = rows_[node];
  const auto u = trajectory.u(node);
  for (int i = 0; i < u.size(); ++i) {
    const Side side = control_sides_[bounds_.offset(node) + i];
    if (side == kInactive) continue;
    rows.A.row(rows.count).setZero();
    rows.A(rows.count, problem_.ndx() + i) = 1;
    const double bound = side == kLower ? bounds_.lower(node)[i] : bounds_.upper(node)[i];
    add_row(rows, kControl, i, -1, u[i] - bound, -adjoint.gradient()[bounds_.offset(node) + i]);
  }
}

void ActiveRows::add_gradient(bool with_controls, Linearization& linearization) const {
  for (int k = 0; k <= problem_.knots(); ++k) {
    const Rows& rows = rows_[k];
    for (int r = 0; r < rows.count; ++r)
      if (with_controls || rows.kind[r] != kControl)
        linearization.knots[k].gradient += rows.multiplier[r] * rows.A.row(r).transpose();
  }
}

void ActiveRows::add_curvature(double penalty, Linearization& linearization) {
  for (int k = 0; k <= problem_.knots(); ++k) {
    const Rows& rows = rows_[k];
    KnotLinearization& knot = linearization.knots[k];
    for (int r = 0; r < rows.count; ++r) {
      if (rows.kind[r] == kLimit) {
        const NodeConstraint& c = problem_.constraints()[rows.constraint[r]];
        if (!c.term->has_bounds() && rows.source[r] == c.row)
          add_outside_curvature(rows.constraint[r], knot, linearization.constraint);
        continue;
      }
      knot.hessian.change().noalias() += penalty * rows.A.row(r).transpose() * rows.A.row(r);
      if (rows.kind[r] != kConeSurface) continue;
      const NodeConstraint& c = problem_.constraints()[rows.constraint[r]];
      const int n = c.term->rows - 1;
      const auto v = linearization.constraint.segment(c.row, n);
      const double length = v.norm(), scale = rows.multiplier[r] / length;
      const auto C = knot.C.middleRows(c.row - problem_.constraint_offset(k), n);
      auto along = scratch_.head(C.cols());
      along.noalias() = C.transpose() * v;
      along /= length;
      for (int i = 0; i < n; ++i)
        knot.hessian.change().noalias() += scale * C.row(i).transpose() * C.row(i);
      knot.hessian.change().noalias() -= scale * along * along.transpose();
    }
  }
}

double ActiveRows::correct(double penalty, const std::vector<Eigen::VectorXd>* step,
                           Linearization& linearization) {
  double largest = 0;
  for (int k = 0; k <= problem_.knots(); ++k) {
    Rows& rows = rows_[k];
    for (int r = 0; r < rows.count; ++r) {
      if (rows.kind[r] == kLimit) continue;
      double rest = rows.value[r];
      if (step != nullptr) rest += rows.A.row(r).dot((*step)[k]);
      largest = std::max(largest, std::abs(rest));
      const double change = penalty * rest;
      rows.correction[r] = step == nullptr ? 0 : rows.correction[r] + change;
      linearization.knots[k].gradient += change * rows.A.row(r).transpose();
    }
  }
  return largest;
}

void ActiveRows::write_multipliers(const Linearization& linearization, bool corrected,
                                   Eigen::VectorXd& multipliers) const {
  multipliers.setZero();
  for (const Rows& rows : rows_)
    for (int r = 0; r < rows.count; ++r) {
      const double value = rows.multiplier[r] + (corrected ? rows.correction[r] : 0);
      if (rows.kind[r] == kControl) continue;
      if (rows.kind[r] != kConeSurface) {
        multipliers[rows.source[r]] = value;
        continue;
      }
      const NodeConstraint& c = problem_.constraints()[rows.constraint[r]];
      const int n = c.term->rows - 1;
      const auto v = linearization.constraint.segment(c.row, n);
      multipliers.segment(c.row, n) = (value / v.norm()) * v;
      multipliers[c.row + n] = -value;
    }
}

int ActiveRows::count() const {
  int count = 0;
  for (const Rows& rows : rows_)
    for (int r = 0; r < rows.count; ++r) count += rows.kind[r] != kLimit;
  return count;
}

}  // namespace conddp
