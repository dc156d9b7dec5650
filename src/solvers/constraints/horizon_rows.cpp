#include "solvers/constraints/horizon_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ocp/evaluation/matrix_vector.hpp"
#include "ocp/terms/constraint.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/constraints/row_lanes.hpp"
#include "solvers/linalg/exchange.hpp"

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

/// Calls f for the runs of rows with bounds, which include the controls during a descent.
template <class F>
inline void HorizonRows::for_each_run(F f) const {
  for (const Run& run : runs_) f(run);
  if (descends_) f(Run{controls_, bounds_.size(), true});
}

/// P at s of the rows of bounds from this row on; P of soft rows stays within its limit.
template <class S>
inline S HorizonRows::outside(int row, const S& s) const {
  const S lower = load_rows<S>(lower_.data() + row), upper = load_rows<S>(upper_.data() + row);
  return limit_outside(outside_bounds(s, lower, upper), load_rows<S>(limit_.data() + row));
}

/// The model of P around s. At the bound, augmentation rows are active and cost rows are not, as in
/// differentiation.
template <class S>
inline void HorizonRows::model_row(int row, const S& s, bool cost, S& offset, S& slope) const {
  const S lower = load_rows<S>(lower_.data() + row), upper = load_rows<S>(upper_.data() + row);
  const S limit = load_rows<S>(limit_.data() + row);
  const S nearest = max(lower, min(upper, s)), outside = s - nearest;
  MaskOf<S> active = !(outside == S(0.0));
  if (!cost) active = active | (s == lower) | (s == upper);
  active = active & (abs(outside) <= limit);
  slope = select(active, S(1.0), S(0.0));
  offset = select(active, -nearest, limit_outside(outside, limit));
}

template double HorizonRows::outside(int, const double&) const;
template void HorizonRows::model_row(int, const double&, bool, double&, double&) const;

/// P of a cone at s, and its derivative if requested.
void HorizonRows::outside_cone_at(const Term& c, const double* s, double* p, double* derivative) {
  for (int i = 0; i < c.count; ++i) point_[i] = value_[c.row + i] + s[i];
  outside_cone(point_.data(), c.count, p);
  const double limit = limit_[c.row];
  if (derivative != nullptr) {
    outside_cone_derivative(point_.data(), c.count, derivative);
    if (std::isfinite(limit)) limit_cone_derivative(p, c.count, limit, derivative);
  }
  if (std::isfinite(limit)) limit_cone(c.count, limit, p);
}

HorizonRows::HorizonRows(const ShootingProblem& problem, const ControlBounds& bounds)
    : problem_(problem),
      bounds_(bounds),
      nodes_(problem.knots() + 1),
      controls_(problem.constraint_rows()),
      update_(problem) {
  for (const NodeConstraint& c : problem.constraints())
    terms_.push_back(
        {c.node, c.row, c.term->rows, c.lower, c.upper, c.term->is_cone(), Kind::constraint});
  add_costs();
  empty_ = terms_.empty();
  for (int k = 0; k < problem.knots(); ++k)
    terms_.push_back({k, controls_ + bounds.offset(k), problem.nu(k), bounds.lower(k).data(),
                      bounds.upper(k).data(), false, Kind::control});
  reserve();
  find_runs();
  reset();
}

/// Adds constraints that are soft by the square of their distance, and barriers.
void HorizonRows::add_costs() {
  for (const NodeConstraint& c : problem_.soft_constraints())
    if (c.term->softness == Softness::l2 && !c.term->grows_with)
      add_cost({c.node, c.row, c.term->rows, c.lower, c.upper, c.term->is_cone(), Kind::cost,
                c.term->weight()});
  for (int k = 0; k <= problem_.knots(); ++k)
    for (const CostTerm& cost : problem_.knot(k).model->costs()) {
      if (!cost.is_barrier() || cost.grows_with) continue;
      const Activation& barrier = cost.activation;
      add_cost({k, problem_.constraint_offset(k) + cost.row, cost.residual->size(),
                barrier.lower.data(), barrier.upper.data(), false, Kind::cost, cost.weight,
                barrier.weights.empty() ? nullptr : barrier.weights.data()});
    }
}

/// Adds a term of constant ρ.
void HorizonRows::add_cost(const Term& cost) {
  const KnotView& knot = problem_.knot(cost.node);
  if (knot.cost_scale * knot.parameters[cost.weight] == 0) return;
  terms_.push_back(cost);
}

void HorizonRows::reserve() {
  const int count = controls_ + bounds_.size();
  for (Eigen::VectorXd* rows : {&value_, &penalty_, &base_, &shifted_, &found_, &offset_, &slope_,
                                &inside_, &multiplier_, &along_})
    *rows = Eigen::VectorXd::Zero(count);
  limit_ = own_limit_ = upper_ = own_upper_ = Eigen::VectorXd::Constant(count, kInfinity);
  lower_ = own_lower_ = -limit_;
  for (int k = 0; k <= problem_.knots(); ++k) {
    const int nz = problem_.knot(k).model->nz();
    nodes_[k].gradient.resize(nz);
    nodes_[k].hessian.resize(nz, nz);
  }
  int most = 0;
  cone_slope_.resize(terms_.size());
  off_.resize(terms_.size());
  term_.assign(count, -1);
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    const Term& c = terms_[i];
    nodes_[c.node].terms.push_back(static_cast<int>(i));
    std::fill_n(term_.begin() + c.row, c.count, static_cast<int>(i));
    most = std::max(most, c.count);
    if (!c.cone) continue;
    cone_slope_[i].setZero(c.count, c.count);
    cones_.push_back(static_cast<int>(i));
    nodes_[c.node].cones = true;
  }
  new_slope_.resize(most, most);
  for (Eigen::VectorXd* v : {&new_offset_, &new_base_, &scratch_, &point_}) v->resize(most);
}

void HorizonRows::find_runs() {
  const auto add_runs = [&](std::vector<Run>& runs, Kind kind, bool cones) {
    const bool cost = kind == Kind::cost;
    for (int row = 0; row < controls_; ++row) {
      const Term* c = term_[row] < 0 ? nullptr : &terms_[term_[row]];
      if (c == nullptr || c->kind != kind || (c->cone && !cones)) continue;
      if (runs.empty() || runs.back().cost != cost || runs.back().row + runs.back().count != row)
        runs.push_back({row, 0, cost});
      ++runs.back().count;
    }
  };
  add_runs(runs_, Kind::constraint, false);
  add_runs(runs_, Kind::cost, false);
  add_runs(augmented_, Kind::constraint, true);
}

void HorizonRows::reset() {
  settled_ = false;
  read_bounds();
  read_weights();
}

/// Reads bounds, and the limits of soft constraints.
void HorizonRows::read_bounds() {
  for (const NodeConstraint& c : problem_.constraints())
    own_limit_.segment(c.row, c.term->rows).setConstant(c.limit);
  for (const Term& c : terms_) {
    if (c.lower == nullptr) continue;
    std::copy_n(c.lower, c.count, own_lower_.data() + c.row);
    std::copy_n(c.upper, c.count, own_upper_.data() + c.row);
  }
}

void HorizonRows::read_weights() {
  for (const Term& c : terms_) {
    if (c.kind != Kind::cost) continue;
    const KnotView& knot = problem_.knot(c.node);
    const double weight = knot.cost_scale * knot.parameters[c.weight];
    for (int r = 0; r < c.count; ++r)
      penalty_[c.row + r] = c.factors == nullptr ? weight : weight * c.factors[r];
  }
}

/// Measures bounds from the values: small differences keep their digits beside a large ρ.
void HorizonRows::measure_bounds() {
  lower_ = own_lower_ - value_;
  upper_ = own_upper_ - value_;
}

void HorizonRows::start(const Linearization& linearization, const Augmentation* augmentation) {
  value_.head(controls_) = linearization.constraint;
  measure_bounds();
  base_.setZero();
  if (augmentation != nullptr) {
    base_.head(controls_) = augmentation->shift;
    for (const Run& run : augmented_)
      penalty_.segment(run.row, run.count) = augmentation->penalty.segment(run.row, run.count);
    measure_limits();
  }
  descends_ = false;
  for (Eigen::VectorXd* rows : {&penalty_, &found_, &offset_, &slope_})
    rows->tail(bounds_.size()).setZero();
  for (Node& node : nodes_) node.changed = false;
  restart();
}

void HorizonRows::restart() {
  for (const int i : cones_) {
    const Term& c = terms_[i];
    outside_cone_at(c, base_.data() + c.row, found_.data() + c.row, cone_slope_[i].data());
    auto offset = offset_.segment(c.row, c.count);
    offset = found_.segment(c.row, c.count);
    offset.noalias() -= cone_slope_[i] * base_.segment(c.row, c.count);
  }
  for (const Run& run : runs_)
    for_each_lane(run.count, [&](auto kind, int r) {
      using S = decltype(kind);
      const int row = run.row + r;
      const S s = load_rows<S>(base_.data() + row);
      S offset, slope;
      model_row(row, s, run.cost, offset, slope);
      store_rows(found_.data() + row, outside(row, s));
      store_rows(offset_.data() + row, offset);
      store_rows(slope_.data() + row, slope);
    });
}

/// values ← C z + ν/ρ of all rows.
void HorizonRows::shift(const std::vector<Eigen::VectorXd>& z, const Linearization& linearization,
                        Eigen::VectorXd& values) const {
  values = base_;
  for (int k = 0; k <= problem_.knots(); ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    multiply_add(knot.C, z[k].data(), values.data() + problem_.constraint_offset(k));
    if (k < problem_.knots())
      values.segment(controls_ + bounds_.offset(k), knot.nu()) += z[k].tail(knot.nu());
  }
}

int HorizonRows::revise(const std::vector<Eigen::VectorXd>& z, double allowed,
                        Linearization& linearization, std::optional<int>& last) {
  shift(z, linearization, shifted_);
  find_error();
  return error_ <= allowed ? 0 : revise(linearization, last);
}

/// found_ ← P(s) at shifted_, error_ ← Σ ρ |P(s) − model|². Marks the bound terms with an
/// inaccurate model, and their nodes and those of cones.
void HorizonRows::find_error() {
  allowed_ = tuning::kExact * found_.lpNorm<Eigen::Infinity>();
  std::fill(off_.begin(), off_.end(), false);
  for (Node& node : nodes_) node.off = node.cones;
  error_ = 0;
  for_each_run([&](const Run& run) { error_ += find_bounds_error(run); });
  for (const int i : cones_) error_ += find_cone_error(i);
}

double HorizonRows::find_bounds_error(const Run& run) {
  double sum = 0;
  for_each_lane(run.count, [&](auto kind, int r) {
    using S = decltype(kind);
    const int row = run.row + r;
    const S found = outside(row, load_rows<S>(shifted_.data() + row));
    store_rows(found_.data() + row, found);
    // Most rows are inactive and stay so.
    const S zero(0.0);
    if (any((!(found == zero)) | (!(load_rows<S>(offset_.data() + row) == zero)) |
            (!(load_rows<S>(slope_.data() + row) == zero))))
      sum += find_rows_error(row, found);
  });
  return sum;
}

/// Error of one row with P found there, or of a lane of rows.
template <class S>
inline double HorizonRows::find_rows_error(int row, const S& found) {
  constexpr int kCount = sizeof(S) / sizeof(double);
  const S offset = load_rows<S>(offset_.data() + row), slope = load_rows<S>(slope_.data() + row);
  double error[kCount], sum = 0;
  store_rows(error, found - (offset + slope * load_rows<S>(shifted_.data() + row)));
  for (int i = 0; i < kCount; ++i) {
    sum += penalty_[row + i] * error[i] * error[i];
    if (std::abs(error[i]) <= allowed_) continue;
    const int term = term_[row + i];
    off_[term] = nodes_[terms_[term].node].off = true;
  }
  return sum;
}

double HorizonRows::find_cone_error(int term) {
  const Term& c = terms_[term];
  outside_cone_at(c, shifted_.data() + c.row, found_.data() + c.row, nullptr);
  auto error = scratch_.head(c.count);
  error = found_.segment(c.row, c.count) - offset_.segment(c.row, c.count);
  error.noalias() -= cone_slope_[term] * shifted_.segment(c.row, c.count);
  return penalty_[c.row] * error.squaredNorm();
}

/// Revises the model around shifted_, with P found_ there. To be called after find_error().
int HorizonRows::revise(Linearization& linearization, std::optional<int>& last) {
  int changes = 0;
  for (int k = 0; k <= problem_.knots(); ++k) {
    Node& node = nodes_[k];
    if (!node.off) continue;
    KnotLinearization& knot = linearization.knots[k];
    for (const int i : node.terms) {
      const bool changed =
          terms_[i].cone ? revise_cone(i, knot) : off_[i] && revise_bounds(terms_[i], knot);
      if (!changed) continue;
      ++changes;
      last = k;
    }
    if (!update_.empty()) update_.apply(knot.hessian);
  }
  return changes;
}

void HorizonRows::expect(Linearization& linearization) {
  if (!settled_) return;
  settled_ = false;
  // Multipliers stay roughly the same for any penalty.
  shifted_ = inside_ - value_;
  for (int row = 0; row < controls_; ++row)
    if (multiplier_[row] != 0) shifted_[row] += multiplier_[row] / penalty_[row];
  find_error();
  std::optional<int> last;
  revise(linearization, last);
}

void HorizonRows::settle() {
  inside_ = value_ + shifted_ - found_;
  multiplier_ = found_.cwiseProduct(penalty_);
  settled_ = true;
}

bool HorizonRows::revise_bounds(const Term& c, KnotLinearization& knot) {
  bool changed = false;
  for (int row = c.row; row < c.row + c.count; ++row) {
    const double s = shifted_[row];
    if (penalty_[row] == 0 || std::abs(found_[row] - model(row, s)) <= allowed_) continue;
    keep(knot, nodes_[c.node]);
    changed = true;
    double offset, slope;
    model_row(row, s, c.kind != Kind::constraint, offset, slope);
    set_row(c, row, offset, slope, base_[row], knot);
  }
  return changed;
}

/// Replaces the model of a row with bounds, and its ν/ρ.
void HorizonRows::set_row(const Term& c, int row, double offset, double slope, double base,
                          KnotLinearization& knot) {
  const double bend = penalty_[row] * (slope - slope_[row]);
  const double push = penalty_[row] * (offset + slope * base - model(row, base_[row]));
  offset_[row] = offset;
  slope_[row] = slope;
  base_[row] = base;
  if (c.kind == Kind::control) {
    const int column = knot.ndx + row - c.row;
    knot.gradient[column] += push;
    if (bend != 0) knot.hessian.change()(column, column) += bend;
    return;
  }
  const auto C = knot.C.row(row - problem_.constraint_offset(c.node));
  knot.gradient += push * C.transpose();
  if (bend != 0) update_.add(C, bend);
}

bool HorizonRows::revise_cone(int term, KnotLinearization& knot) {
  const Term& c = terms_[term];
  const auto s = shifted_.segment(c.row, c.count);
  auto offset = new_offset_.head(c.count);
  const auto found = found_.segment(c.row, c.count);
  offset = found - offset_.segment(c.row, c.count);
  offset.noalias() -= cone_slope_[term] * s;
  if (offset.norm() <= std::max(allowed_, tuning::kConeShare * found.norm())) return false;
  keep(knot, nodes_[c.node]);
  Eigen::Map<Eigen::MatrixXd> slope(new_slope_.data(), c.count, c.count);
  outside_cone_at(c, s.data(), offset.data(), slope.data());
  offset.noalias() -= slope * s;
  new_base_.head(c.count) = base_.segment(c.row, c.count);
  set_cone(term, knot);
  return true;
}

/// Replaces the model of a cone, and its ν/ρ, by the new ones.
void HorizonRows::set_cone(int term, KnotLinearization& knot) {
  const Term& c = terms_[term];
  const int n = c.count;
  Eigen::MatrixXd& slope = cone_slope_[term];
  const Eigen::Map<Eigen::MatrixXd> new_slope(new_slope_.data(), n, n);
  auto offset = offset_.segment(c.row, n), base = base_.segment(c.row, n);
  auto push = scratch_.head(n);
  push = new_offset_.head(n) - offset;
  push.noalias() += new_slope * new_base_.head(n);
  push.noalias() -= slope * base;
  const auto C = jacobian(c, knot);
  knot.gradient.noalias() += penalty_[c.row] * (C.transpose() * push);
  slope = penalty_[c.row] * (new_slope - slope);
  update_.add(C, slope);
  slope = new_slope;
  offset = new_offset_.head(n);
  base = new_base_.head(n);
}

void HorizonRows::keep(const KnotLinearization& knot, Node& node) {
  if (node.changed) return;
  node.gradient = knot.gradient;
  node.hessian = knot.hessian();
  node.changed = true;
}

bool HorizonRows::restore(Linearization& linearization) {
  bool changed = false;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    if (!nodes_[k].changed) continue;
    linearization.knots[k].gradient = nodes_[k].gradient;
    KnotHessian& hessian = linearization.knots[k].hessian;
    hessian.change(hessian.fill()).swap(nodes_[k].hessian);
    nodes_[k].changed = false;
    changed = true;
  }
  return changed;
}

void HorizonRows::exchange_memory(HorizonRows& other) {
  for (std::size_t k = 0; k < std::min(nodes_.size(), other.nodes_.size()); ++k)
    exchange(nodes_[k].hessian, other.nodes_[k].hessian);
}

void HorizonRows::begin_descent(const Trajectory& trajectory, const Eigen::VectorXd& gradient,
                                const BackwardSweep& sweep, const Linearization& linearization) {
  for (std::size_t k = 0; k < nodes_.size(); ++k) keep(linearization.knots[k], nodes_[k]);
  descends_ = true;
  for (int k = 0; k < bounds_.knots(); ++k) {
    const auto u = trajectory.u(k);
    for (int i = 0; i < u.size(); ++i) {
      const int row = controls_ + bounds_.offset(k) + i;
      const double slope = gradient[bounds_.offset(k) + i];
      value_[row] = u[i];
      penalty_[row] = tuning::kControlWeight * sweep.Quu(k)(i, i);
      base_[row] = bounds_.pushed_out(k, i, u[i], slope) ? -slope / penalty_[row] : 0;
    }
  }
  measure_bounds();
}

void HorizonRows::end_descent(ActiveSet& active_set, Linearization& linearization) {
  descends_ = false;
  for (const Term& c : terms_) {
    if (c.kind != Kind::control) continue;
    active_set.assume_sides(c.node, found_.segment(c.row, c.count));
    for (int row = c.row; row < c.row + c.count; ++row) {
      set_row(c, row, 0, 0, 0, linearization.knots[c.node]);
      found_[row] = penalty_[row] = 0;
    }
  }
}

void HorizonRows::set_path(const std::vector<Eigen::VectorXd>& z,
                           const std::vector<Eigen::VectorXd>& to,
                           const Linearization& linearization) {
  shift(z, linearization, shifted_);
  shift(to, linearization, along_);
  along_ -= shifted_;
}

double HorizonRows::slope_beyond_model(double alpha) {
  double sum = 0;
  for_each_run([&](const Run& run) {
    for (int row = run.row; row < run.row + run.count; ++row) {
      const double s = shifted_[row] + alpha * along_[row];
      sum += penalty_[row] * (outside(row, s) - model(row, s)) * along_[row];
    }
  });
  for (const int i : cones_) {
    const Term& c = terms_[i];
    const auto along = along_.segment(c.row, c.count);
    auto s = new_base_.head(c.count), found = new_offset_.head(c.count);
    s = shifted_.segment(c.row, c.count) + alpha * along;
    outside_cone_at(c, s.data(), found.data(), nullptr);
    found -= offset_.segment(c.row, c.count);
    found.noalias() -= cone_slope_[i] * s;
    sum += penalty_[c.row] * found.dot(along);
  }
  return sum;
}

}  // namespace conddp
