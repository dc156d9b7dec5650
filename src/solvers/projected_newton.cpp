#include "solvers/projected_newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace conddp {
namespace {

/// Penalty of active rows in a sweep, as a multiple of the largest curvature, and how often the
/// multipliers are corrected for it.
constexpr double kRowPenalty = 1e5;
constexpr int kCorrections = 10;
constexpr double kExactRows = 1e-9;
/// Shortest step that is tried.
constexpr double kShortestStep = 0.125;
/// A control this close to a bound stands there.
constexpr double kAtBound = 1e-9;

/// Where a row of a node comes from.
enum Kind { kBounds, kConeSurface, kConeTip, kControl };

}  // namespace

double KktNorms::largest() const {
  const double sum = stationarity.value + gap.value + violation.value;
  return std::isfinite(sum) ? std::max({stationarity.value, gap.value, violation.value}) : sum;
}

ProjectedNewton::ProjectedNewton(const ShootingProblem& problem, Acts& acts)
    : problem_(problem),
      acts_(acts),
      bounds_(problem),
      linearization_(problem),
      adjoint_(problem, bounds_),
      sweep_(problem, bounds_),
      policy_(unconstrained_stage(problem)),
      gaps_(problem),
      feedback_(problem),
      trajectory_(problem.create_trajectory()),
      before_(trajectory_),
      lagrangian_(problem),
      multipliers_(Eigen::VectorXd::Zero(problem.constraint_rows())),
      multipliers_before_(multipliers_),
      target_(multipliers_),
      penalty_(multipliers_),
      rows_(problem.knots() + 1),
      constraints_of_(problem.knots() + 1),
      scratch_(problem.ndx()) {
  acts.reserve_lagrangian_hessian();
  for (std::size_t i = 0; i < problem.constraints().size(); ++i)
    constraints_of_[problem.constraints()[i].node].push_back(static_cast<int>(i));
  int largest = 0;
  for (int k = 0; k <= problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    const int m = model.constraint_rows() + model.nu();
    Rows& rows = rows_[k];
    rows.A = Eigen::MatrixXd::Zero(m, model.nz());
    for (Eigen::VectorXd* v : {&rows.value, &rows.multiplier, &rows.correction})
      *v = Eigen::VectorXd::Zero(m);
    rows.source.resize(m);
    rows.kind.resize(m);
    gauss_newton_.push_back(linearization_.knots[k].hessian);
    step_.push_back(Eigen::VectorXd::Zero(model.nz()));
    largest = std::max(largest, model.nz());
  }
  z_.resize(largest);
}

void ProjectedNewton::start(const Trajectory& trajectory, const Eigen::VectorXd& multipliers,
                            const Eigen::VectorXd& penalty, const Feedback& feedback) {
  trajectory_ = trajectory;
  multipliers_ = multipliers;
  penalty_ = penalty;
  feedback_ = feedback;
  step_length_ = 0;
  linearize();
}

/// Derivatives, active rows, co-states and norms of the iterate.
void ProjectedNewton::linearize() {
  lagrangian_.multiplier = multipliers_;
  for (const NodeConstraint& c : problem_.constraints())
    if (!c.term->has_bounds()) lagrangian_.multiplier.segment(c.row, c.term->rows).setZero();
  // Entries that are zero by the costs' structure are left alone, and the last step filled them.
  for (KnotLinearization& knot : linearization_.knots) knot.hessian.setZero();
  acts_.differentiate(trajectory_, linearization_, &lagrangian_);
  for (int k = 0; k <= problem_.knots(); ++k) find_active(k);
  gaps_.set(linearization_, true);
  adjoint_.compute(linearization_, trajectory_, gaps_, feedback_);
  for (int k = 0; k < problem_.knots(); ++k) add_controls(k);
  measure();
}

/// The active constraint rows of a node. Multipliers of the others become zero, also in the
/// gradient; those of cones are turned to the direction of the surface.
void ProjectedNewton::find_active(int node) {
  Rows& rows = rows_[node];
  KnotLinearization& knot = linearization_.knots[node];
  const int offset = problem_.constraint_offset(node);
  rows.count = 0;
  for (const int index : constraints_of_[node]) {
    const NodeConstraint& c = problem_.constraints()[index];
    const auto C = knot.C.middleRows(c.row - offset, c.term->rows);
    if (!c.term->has_bounds()) {
      add_cone(c, C, rows);
      continue;
    }
    for (int i = 0; i < c.term->rows; ++i) {
      double& multiplier = multipliers_[c.row + i];
      const double g = linearization_.constraint[c.row + i];
      const double outside =
          outside_bounds(g + multiplier / penalty_[c.row + i], c.lower[i], c.upper[i]);
      if (outside == 0 && c.lower[i] < c.upper[i]) {
        if (multiplier != 0) knot.gradient -= multiplier * C.row(i).transpose();
        multiplier = 0;
        continue;
      }
      rows.A.row(rows.count) = C.row(i);
      rows.value[rows.count] = g - (outside < 0 ? c.lower[i] : c.upper[i]);
      rows.multiplier[rows.count] = multiplier;
      rows.source[rows.count] = c.row + i;
      rows.kind[rows.count++] = kBounds;
    }
  }
  for (int r = 0; r < rows.count; ++r)
    if (rows.kind[r] != kBounds) knot.gradient += rows.multiplier[r] * rows.A.row(r).transpose();
}

void ProjectedNewton::add_cone(const NodeConstraint& c, const Eigen::Ref<const Eigen::MatrixXd>& C,
                               Rows& rows) {
  const int n = c.term->rows;
  auto nu = multipliers_.segment(c.row, n);
  const auto g = linearization_.constraint.segment(c.row, n);
  const double rho = penalty_[c.row];
  double square = 0;
  for (int i = 0; i + 1 < n; ++i) square += std::pow(g[i] + nu[i] / rho, 2);
  const double a = std::sqrt(square), t = g[n - 1] + nu[n - 1] / rho;
  if (a <= t) {
    nu.setZero();
    return;
  }
  const double length = g.head(n - 1).norm();
  if (a <= -t || length == 0) {
    for (int i = 0; i < n; ++i) {
      rows.A.row(rows.count) = C.row(i);
      rows.value[rows.count] = g[i];
      rows.multiplier[rows.count] = nu[i];
      rows.source[rows.count] = c.row + i;
      rows.kind[rows.count++] = kConeTip;
    }
    return;
  }
  auto row = rows.A.row(rows.count);
  row = -C.row(n - 1);
  for (int i = 0; i + 1 < n; ++i) row += (g[i] / length) * C.row(i);
  const double surface = std::max(0.0, -nu[n - 1]);
  nu.head(n - 1) = (surface / length) * g.head(n - 1);
  nu[n - 1] = -surface;
  rows.value[rows.count] = length - g[n - 1];
  rows.multiplier[rows.count] = surface;
  rows.source[rows.count] = c.row;
  rows.kind[rows.count++] = kConeSurface;
}

/// Bounds on the control at which it stands, pushed outward, or which it violates.
void ProjectedNewton::add_controls(int node) {
  Rows& rows = rows_[node];
  const auto u = trajectory_.u(node);
  const auto gradient = adjoint_.gradient().segment(bounds_.offset(node), u.size());
  for (int i = 0; i < u.size(); ++i) {
    const double below = u[i] - bounds_.lower(node)[i], above = u[i] - bounds_.upper(node)[i];
    const bool at_lower = below < 0 || (below <= kAtBound && gradient[i] > 0);
    const bool at_upper = above > 0 || (above >= -kAtBound && gradient[i] < 0);
    if (!at_lower && !at_upper) continue;
    rows.A.row(rows.count).setZero();
    rows.A(rows.count, problem_.ndx() + i) = 1;
    rows.value[rows.count] = at_lower ? below : above;
    rows.multiplier[rows.count] = -gradient[i];
    rows.source[rows.count] = i;
    rows.kind[rows.count++] = kControl;
  }
}

void ProjectedNewton::measure() {
  norms_.stationarity = bounds_.projected_norm(adjoint_.gradient(), trajectory_);
  norms_.violation = bounds_.violation(trajectory_);
  norms_.complementarity = 0;
  for (const NodeConstraint& c : problem_.constraints()) {
    norms_.complementarity = std::max(
        norms_.complementarity, complementarity(*c.term, linearization_.constraint.data() + c.row,
                                                c.lower, c.upper, multipliers_.data() + c.row));
    const double distance =
        distance_to_set(*c.term, linearization_.constraint.data() + c.row, c.lower, c.upper);
    if (!(distance <= norms_.violation.value)) norms_.violation = {distance, c.node};
  }
  norms_.gap = {};
  for (int k = 0; k < problem_.knots(); ++k) {
    const double gap = linearization_.gap.col(k).lpNorm<Eigen::Infinity>();
    if (!(gap <= norms_.gap.value)) norms_.gap = {gap, k};
  }
}

/// The curvature of a node's cones, and of its active rows as penalties.
void ProjectedNewton::add_curvature(int node, double penalty) {
  const Rows& rows = rows_[node];
  KnotLinearization& knot = linearization_.knots[node];
  const int offset = problem_.constraint_offset(node);
  for (int r = 0; r < rows.count; ++r) {
    knot.hessian.noalias() += penalty * rows.A.row(r).transpose() * rows.A.row(r);
    if (rows.kind[r] != kConeSurface) continue;
    for (const int index : constraints_of_[node]) {
      const NodeConstraint& c = problem_.constraints()[index];
      if (c.row != rows.source[r]) continue;
      const int n = c.term->rows - 1;
      const auto v = linearization_.constraint.segment(c.row, n);
      const double length = v.norm(), scale = rows.multiplier[r] / length;
      const auto C = knot.C.middleRows(c.row - offset, n);
      z_.head(C.cols()).noalias() = C.transpose() * v;
      z_.head(C.cols()) /= length;
      const auto along = z_.head(C.cols());
      for (int i = 0; i < n; ++i) knot.hessian.noalias() += scale * C.row(i).transpose() * C.row(i);
      knot.hessian.noalias() -= scale * along * along.transpose();
    }
  }
}

/// Adds multipliers of the active rows to the gradients: at first penalty times values, later
/// penalty times what the last step leaves of them. Returns the largest of the latter.
double ProjectedNewton::correct(double penalty, bool first) {
  double largest = 0;
  for (int k = 0; k <= problem_.knots(); ++k) {
    Rows& rows = rows_[k];
    for (int r = 0; r < rows.count; ++r) {
      double rest = rows.value[r];
      if (!first) rest += rows.A.row(r).dot(step_[k]);
      largest = std::max(largest, std::abs(rest));
      const double change = penalty * rest;
      rows.correction[r] = first ? 0 : rows.correction[r] + change;
      // The gradient has the multipliers of constraints, but not those of bounds on the control.
      const double own = first && rows.kind[r] == kControl ? rows.multiplier[r] : 0;
      linearization_.knots[k].gradient += (change + own) * rows.A.row(r).transpose();
    }
  }
  return largest;
}

/// A sweep and the step of its policy in the linear model.
bool ProjectedNewton::sweep() {
  if (sweep_.run(linearization_, trajectory_, gaps_, {}, *policy_, feedback_) >= 0) return false;
  auto dx = scratch_.head(problem_.ndx());
  dx.setZero();
  for (int k = 0; k <= problem_.knots(); ++k) {
    step_[k].head(dx.size()) = dx;
    if (k == problem_.knots()) break;
    auto du = step_[k].tail(problem_.nu(k));
    du = feedback_.k[k];
    du.noalias() += feedback_.K[k] * dx;
    linearization_.knots[k].apply(step_[k], dx);
    if (!gaps_[k].closed()) gaps_[k].push(dx);
  }
  return step_.back().allFinite();
}

/// Fills step_ and target_. Where the exact Hessian is not convex on the active rows, the
/// Gauss-Newton one is taken.
bool ProjectedNewton::solve_quadratic() {
  double curvature = 0;
  for (std::size_t k = 0; k < gauss_newton_.size(); ++k) {
    gauss_newton_[k] = linearization_.knots[k].hessian;
    curvature = std::max(curvature, gauss_newton_[k].diagonal().maxCoeff());
  }
  lagrangian_.multiplier = multipliers_;
  acts_.lagrangian_hessian(trajectory_, adjoint_.costates(), linearization_, &lagrangian_);
  const double penalty = kRowPenalty * std::max(curvature, 1e-6);
  const double before = correct(penalty, true);
  for (const bool exact : {true, false}) {
    if (!exact)
      for (std::size_t k = 0; k < gauss_newton_.size(); ++k)
        linearization_.knots[k].hessian = gauss_newton_[k];
    for (int k = 0; k <= problem_.knots(); ++k) add_curvature(k, penalty);
    if (sweep()) break;
    if (!exact) return false;
  }
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kCorrections; ++i) {
    const double rest = correct(penalty, false);
    if (rest <= kExactRows * before || rest >= 0.5 * last) break;
    last = rest;
    if (!sweep()) return false;
  }
  set_target();
  return true;
}

/// The multipliers that the full step leads to.
void ProjectedNewton::set_target() {
  target_ = multipliers_;
  for (int k = 0; k <= problem_.knots(); ++k) {
    const Rows& rows = rows_[k];
    for (int r = 0; r < rows.count; ++r) {
      if (rows.kind[r] == kBounds || rows.kind[r] == kConeTip)
        target_[rows.source[r]] += rows.correction[r];
      if (rows.kind[r] != kConeSurface) continue;
      const double surface = rows.multiplier[r] + rows.correction[r];
      for (const int index : constraints_of_[k]) {
        const NodeConstraint& c = problem_.constraints()[index];
        if (c.row != rows.source[r]) continue;
        const int n = c.term->rows - 1;
        const auto v = linearization_.constraint.segment(c.row, n);
        target_.segment(c.row, n) = (surface / v.norm()) * v;
        target_[c.row + n] = -surface;
      }
    }
  }
}

bool ProjectedNewton::step(double growth) {
  const double was = norms_.largest();
  before_ = trajectory_;
  if (!solve_quadratic()) {
    linearize();
    return false;
  }
  multipliers_before_ = multipliers_;
  for (step_length_ = 1; step_length_ >= kShortestStep; step_length_ /= 2) {
    for (int k = 0; k <= problem_.knots(); ++k) {
      auto dx = scratch_.head(problem_.ndx());
      dx = step_length_ * step_[k].head(problem_.ndx());
      problem_.manifold().integrate(before_.x(k).data(), dx.data(), trajectory_.x(k).data());
      if (k < problem_.knots())
        trajectory_.u(k) = before_.u(k) + step_length_ * step_[k].tail(problem_.nu(k));
    }
    bounds_.clamp(trajectory_);
    multipliers_ = multipliers_before_ + step_length_ * (target_ - multipliers_before_);
    linearize();
    if (norms_.largest() < (1 - 0.1 * step_length_) * growth * was) return true;
  }
  trajectory_ = before_;
  multipliers_ = multipliers_before_;
  step_length_ = 0;
  linearize();
  return false;
}

void ProjectedNewton::describe(IterationRecord& row) const {
  row.cost = row.merit = cost();
  row.stationarity = norms_.stationarity.value;
  row.stationarity_knot = norms_.stationarity.knot;
  row.gap = norms_.gap.value;
  row.gap_knot = norms_.gap.knot;
  row.constraint = norms_.violation.value;
  row.constraint_knot = norms_.violation.knot;
  row.complementarity = norms_.complementarity;
  row.step = step_length_;
  row.active_rows = active_rows();
  row.regularization = row.barrier = row.expected_decrease = row.actual_decrease = 0;
  row.trials = row.clamped_controls = row.active_set_changes = 0;
}

int ProjectedNewton::active_rows() const {
  int count = 0;
  for (const Rows& rows : rows_) count += rows.count;
  return count;
}

}  // namespace conddp
