#include "solvers/constraints/active_rows.hpp"

#include <algorithm>
#include <cmath>

#include "ocp/evaluation/matrix_vector.hpp"

namespace conddp {
namespace {

/// Sets a side. True if it changed.
bool replace(RowSide& side, RowSide now) {
  const bool changed = side != now;
  side = now;
  return changed;
}

/// Revises the larger row of a pair. A row that is released and violated at once becomes active
/// again, as a change.
bool revise_pair_row(RowSide& side, double value, double multiplier) {
  bool changed = false;
  if (side == RowSide::lower && multiplier >= 0) changed |= replace(side, RowSide::inactive);
  if (side == RowSide::inactive && is_violated(-value, 0)) changed |= replace(side, RowSide::lower);
  return changed;
}

/// Bound of an active row of bounds; 0 for a row of a pair.
double bound_of(const NodeConstraint& c, int row, RowSide side) {
  if (!c.term->has_bounds()) return 0;
  return side == RowSide::upper ? c.upper[row] : c.lower[row];
}

}  // namespace

ActiveRows::ActiveRows(const ShootingProblem& problem, const ControlBounds& bounds)
    : problem_(problem),
      bounds_(bounds),
      constraints_of_(problem.knots() + 1),
      sides_(problem.constraint_rows(), RowSide::inactive),
      control_sides_(bounds.size(), RowSide::inactive),
      target_(Eigen::VectorXd::Zero(problem.constraint_rows())) {
  int largest = 0, most = 0, cone = 0;
  for (int k = 0; k <= problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    const int rows = model.constraint_rows() + model.nu();
    rows_.emplace_back(rows, model.nz());
    largest = std::max(largest, model.nz());
    most = std::max(most, rows);
  }
  for (std::size_t i = 0; i < problem.constraints().size(); ++i) {
    const NodeConstraint& c = problem.constraints()[i];
    constraints_of_[c.node].push_back(static_cast<int>(i));
    if (c.is_soft() && !c.term->has_bounds()) cone = std::max(cone, c.term->rows);
  }
  scratch_.resize(largest);
  slope_.resize(cone, cone);
  product_.resize(cone, largest);
  predicted_.resize(most);
}

void ActiveRows::choose(const Linearization& linearization, const Eigen::VectorXd& penalty,
                        Eigen::VectorXd& multipliers) {
  for (const NodeConstraint& c : problem_.constraints())
    choose_sides(c, linearization.constraint.data() + c.row, multipliers.data() + c.row,
                 penalty.data() + c.row);
  for (int k = 0; k <= problem_.knots(); ++k) build(k, linearization, multipliers);
  write_multipliers(linearization, false, multipliers);
}

/// Chooses the sides of one constraint from the data of its rows.
void ActiveRows::choose_sides(const NodeConstraint& c, const double* g, const double* nu,
                              const double* rho) {
  RowSide* sides = sides_.data() + c.row;
  if (c.term->is_cone()) {
    *sides = chosen_cone(c, g, nu, *rho);
  } else if (c.term->has_pairs()) {
    for (int i = 0; i < c.term->rows; i += 2) choose_pair(g + i, nu + i, rho + i, sides + i);
  } else {
    for (int i = 0; i < c.term->rows; ++i) sides[i] = chosen_bound(c, i, g[i], nu[i], rho[i]);
  }
}

void ActiveRows::choose_controls(const Trajectory& trajectory, const Adjoint& adjoint) {
  for (int k = 0; k < problem_.knots(); ++k) {
    const auto u = trajectory.u(k);
    for (int i = 0; i < u.size(); ++i)
      control_sides_[bounds_.offset(k) + i] =
          chosen_control(u[i], bounds_.lower(k)[i], bounds_.upper(k)[i],
                         adjoint.gradient()[bounds_.offset(k) + i]);
    build_controls(k, trajectory, adjoint);
  }
}

bool ActiveRows::revise(const Linearization& linearization, const Trajectory& trajectory,
                        const Adjoint& adjoint, const Eigen::VectorXd& multipliers,
                        const std::vector<Eigen::VectorXd>& step) {
  write_multipliers(linearization, true, target_);
  bool changed = false;
  for (int k = 0; k <= problem_.knots(); ++k) {
    predict(k, linearization, step[k]);
    for (const int index : constraints_of_[k])
      changed |= revise_constraint(problem_.constraints()[index], linearization);
    if (k < problem_.knots()) changed |= revise_controls(k, trajectory, step[k]);
  }
  if (!changed) return false;
  for (int k = 0; k <= problem_.knots(); ++k) {
    build(k, linearization, multipliers);
    if (k < problem_.knots()) build_controls(k, trajectory, adjoint);
  }
  return true;
}

/// predicted_ ← the values of a node's constraints after a step.
void ActiveRows::predict(int node, const Linearization& linearization,
                         const Eigen::VectorXd& step) {
  const Eigen::MatrixXd& C = linearization.knots[node].C;
  predicted_.head(C.rows()) =
      linearization.constraint.segment(problem_.constraint_offset(node), C.rows());
  multiply_add(C, step.data(), predicted_.data());
}

/// Revises by predicted_ and target_. True if anything changed.
bool ActiveRows::revise_constraint(const NodeConstraint& c, const Linearization& linearization) {
  const int n = c.term->rows;
  const double* g = linearization.constraint.data() + c.row;
  const auto values = predicted_.segment(c.row - problem_.constraint_offset(c.node), n);
  const auto nu = target_.segment(c.row, n);
  RowSide* sides = sides_.data() + c.row;
  if (c.term->is_cone()) return replace(*sides, revised_cone(c, *sides, g, values, nu));
  bool changed = false;
  for (int i = 0; i < n; ++i)
    changed |= c.term->has_pairs()
                   ? revise_pair_row(sides[i], values[i], nu[i])
                   : replace(sides[i], revised_bound(c, i, sides[i], values[i], nu[i]));
  return changed;
}

/// True if anything changed.
bool ActiveRows::revise_controls(int node, const Trajectory& trajectory,
                                 const Eigen::VectorXd& step) {
  const bool held = hold_violated_controls(node, trajectory, step);
  const bool released = release_controls(node);
  return held || released;
}

/// Holds controls that a step takes beyond a bound. True if it finds any.
bool ActiveRows::hold_violated_controls(int node, const Trajectory& trajectory,
                                        const Eigen::VectorXd& step) {
  bool changed = false;
  RowSide* sides = control_sides_.data() + bounds_.offset(node);
  const auto u = trajectory.u(node);
  const auto du = step.tail(u.size());
  for (int i = 0; i < u.size(); ++i) {
    if (sides[i] != RowSide::inactive) continue;
    const double lower = bounds_.lower(node)[i], upper = bounds_.upper(node)[i];
    if (is_violated(lower - u[i] - du[i], lower)) changed |= replace(sides[i], RowSide::lower);
    if (is_violated(u[i] + du[i] - upper, upper)) changed |= replace(sides[i], RowSide::upper);
  }
  return changed;
}

/// Releases held controls whose multiplier pulls. True if it finds any.
bool ActiveRows::release_controls(int node) {
  bool changed = false;
  RowSide* sides = control_sides_.data() + bounds_.offset(node);
  const Rows& rows = rows_[node];
  for (int r = 0; r < rows.count; ++r) {
    if (rows.kind[r] != kControl) continue;
    RowSide& side = sides[rows.source[r]];
    const double multiplier = rows.multiplier[r] + rows.correction[r];
    if (side == RowSide::lower ? multiplier > 0 : multiplier < 0)
      changed |= replace(side, RowSide::inactive);
  }
  return changed;
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

/// Builds the rows of a node's constraints; the rows of its controls follow.
void ActiveRows::build(int node, const Linearization& linearization,
                       const Eigen::VectorXd& multipliers) {
  Rows& rows = rows_[node];
  rows.count = 0;
  for (const int index : constraints_of_[node]) {
    const NodeConstraint& c = problem_.constraints()[index];
    if (!c.term->is_cone())
      build_bounds(rows, index, linearization, multipliers);
    else if (sides_[c.row] == RowSide::outside)
      build_outside(rows, index, linearization);
    else if (sides_[c.row] == RowSide::surface)
      build_surface(rows, index, linearization, multipliers);
    else if (sides_[c.row] == RowSide::tip)
      build_tip(rows, index, linearization, multipliers);
  }
}

void ActiveRows::build_bounds(Rows& rows, int index, const Linearization& linearization,
                              const Eigen::VectorXd& multipliers) {
  const NodeConstraint& c = problem_.constraints()[index];
  for (int i = 0; i < c.term->rows; ++i) {
    const RowSide side = sides_[c.row + i];
    if (side == RowSide::inactive) continue;
    rows.A.row(rows.count) = rows_of(c, linearization).row(i);
    if (side == RowSide::below || side == RowSide::above) {
      add_row(rows, kLimit, c.row + i, index, 0, side == RowSide::below ? -c.limit : c.limit);
      continue;
    }
    add_row(rows, kBounds, c.row + i, index,
            linearization.constraint[c.row + i] - bound_of(c, i, side), multipliers[c.row + i]);
  }
}

void ActiveRows::build_surface(Rows& rows, int index, const Linearization& linearization,
                               const Eigen::VectorXd& multipliers) {
  const NodeConstraint& c = problem_.constraints()[index];
  const int n = c.term->rows;
  const auto C = rows_of(c, linearization);
  const auto g = linearization.constraint.segment(c.row, n);
  const double length = g.head(n - 1).norm();
  auto row = rows.A.row(rows.count);
  row = -C.row(n - 1);
  for (int i = 0; i + 1 < n; ++i) row += (g[i] / length) * C.row(i);
  add_row(rows, kConeSurface, c.row, index, length - g[n - 1],
          std::max(0.0, -multipliers[c.row + n - 1]));
}

void ActiveRows::build_tip(Rows& rows, int index, const Linearization& linearization,
                           const Eigen::VectorXd& multipliers) {
  const NodeConstraint& c = problem_.constraints()[index];
  for (int i = 0; i < c.term->rows; ++i) {
    rows.A.row(rows.count) = rows_of(c, linearization).row(i);
    add_row(rows, kConeTip, c.row + i, index, linearization.constraint[c.row + i],
            multipliers[c.row + i]);
  }
}

/// Builds the rows of a violated soft cone. It pushes with its full limit, straight towards itself.
void ActiveRows::build_outside(Rows& rows, int index, const Linearization& linearization) {
  const NodeConstraint& c = problem_.constraints()[index];
  const int n = c.term->rows;
  auto push = predicted_.head(n);
  outside_cone(linearization.constraint.data() + c.row, n, push.data());
  push *= c.limit / push.norm();
  for (int i = 0; i < n; ++i) {
    rows.A.row(rows.count) = rows_of(c, linearization).row(i);
    add_row(rows, kLimit, c.row + i, index, 0, push[i]);
  }
}

/// Adds the curvature of such a cone: that of the distance, times the limit.
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
    const RowSide side = control_sides_[bounds_.offset(node) + i];
    if (side == RowSide::inactive) continue;
    rows.A.row(rows.count).setZero();
    rows.A(rows.count, problem_.ndx() + i) = 1;
    const double bound = side == RowSide::lower ? bounds_.lower(node)[i] : bounds_.upper(node)[i];
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
        add_limit_curvature(rows, r, knot, linearization.constraint);
        continue;
      }
      knot.hessian.change().noalias() += penalty * rows.A.row(r).transpose() * rows.A.row(r);
      if (rows.kind[r] == kConeSurface)
        add_surface_curvature(rows.constraint[r], rows.multiplier[r], linearization);
    }
  }
}

/// Adds the curvature of a row at the limit of a soft constraint. The first row of a cone adds that
/// of the cone; rows of bounds add nothing.
void ActiveRows::add_limit_curvature(const Rows& rows, int row, KnotLinearization& knot,
                                     const Eigen::VectorXd& values) {
  const int index = rows.constraint[row];
  const NodeConstraint& c = problem_.constraints()[index];
  if (!c.term->has_bounds() && rows.source[row] == c.row)
    add_outside_curvature(index, knot, values);
}

/// Adds multiplier · ∇²‖v‖ of the cone's tangential rows v.
void ActiveRows::add_surface_curvature(int index, double multiplier, Linearization& linearization) {
  const NodeConstraint& c = problem_.constraints()[index];
  const int n = c.term->rows - 1;
  const auto v = linearization.constraint.segment(c.row, n);
  const double length = v.norm(), scale = multiplier / length;
  const auto C = rows_of(c, linearization).topRows(n);
  auto along = scratch_.head(C.cols());
  along.noalias() = C.transpose() * v;
  along /= length;
  Eigen::MatrixXd& hessian = linearization.knots[c.node].hessian.change();
  for (int i = 0; i < n; ++i) hessian.noalias() += scale * C.row(i).transpose() * C.row(i);
  hessian.noalias() -= scale * along * along.transpose();
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
