#include "solvers/constraints/horizon_constraints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ocp/evaluation/matrix_vector.hpp"
#include "ocp/terms/constraint.hpp"
#include "solvers/constraints/row_lanes.hpp"
#include "solvers/linalg/exchange.hpp"

namespace conddp {
namespace {

/// Allowed error of the model of P, as a share of the largest P of the horizon, and of a cone's own
/// P, whose slope changes everywhere.
constexpr double kExact = 1e-9;
constexpr double kConeShare = 0.02;
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

}  // namespace

/// P at s of the rows of bounds from this row on; P of soft rows stays within its limit.
template <class S>
inline S HorizonConstraints::outside_rows(int row, const S& s) const {
  const S lower = load_rows<S>(lower_.data() + row), upper = load_rows<S>(upper_.data() + row);
  return limit_outside(outside_bounds(s, lower, upper), load_rows<S>(limit_.data() + row));
}

/// Slopes of the same rows. At the bound, augmentation rows are active and cost rows are not, as in
/// differentiation.
template <class S>
inline S HorizonConstraints::row_slopes(int row, const S& s, bool cost) const {
  const S lower = load_rows<S>(lower_.data() + row), upper = load_rows<S>(upper_.data() + row);
  const S outside = outside_bounds(s, lower, upper);
  MaskOf<S> counts = !(outside == S(0.0));
  if (!cost) counts = counts | (s == lower) | (s == upper);
  const MaskOf<S> within = abs(outside) <= load_rows<S>(limit_.data() + row);
  return select(counts & within, S(1.0), S(0.0));
}

/// P of a cone at s, and its derivative if requested.
void HorizonConstraints::outside_cone_at(const Rows& c, const double* s, double limit, double* p,
                                         double* derivative) {
  const bool limited = std::isfinite(c.limit);
  outside_cone(s, c.count, p);
  if (derivative != nullptr) {
    outside_cone_derivative(s, c.count, derivative);
    if (limited) limit_cone_derivative(p, c.count, limit, derivative);
  }
  if (limited) limit_cone(c.count, limit, p);
}

HorizonConstraints::HorizonConstraints(const ShootingProblem& problem)
    : problem_(problem), nodes_(problem.knots() + 1), update_(problem) {
  for (Eigen::VectorXd* rows : {&penalty_, &base_, &around_, &shifted_, &found_, &outside_, &slope_,
                                &along_, &inside_, &multiplier_})
    *rows = Eigen::VectorXd::Zero(problem.constraint_rows());
  for (const NodeConstraint& c : problem.constraints())
    rows_.push_back({c.node, c.row, c.term->rows, c.lower, c.upper, c.limit, false});
  add_soft_costs();
  for (int k = 0; k <= problem.knots(); ++k) add_barriers(k);
  if (rows_.empty()) return;
  reserve();
  find_runs();
  read_bounds();
  read_weights();
}

void HorizonConstraints::reserve() {
  for (int k = 0; k <= problem_.knots(); ++k) {
    const int nz = problem_.knot(k).model->nz();
    nodes_[k].gradient.resize(nz);
    nodes_[k].hessian.resize(nz, nz);
  }
  int most = 0;
  cone_slope_.resize(rows_.size());
  off_.resize(rows_.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Rows& c = rows_[i];
    nodes_[c.node].terms.push_back(static_cast<int>(i));
    most = std::max(most, c.count);
    if (c.lower != nullptr) continue;
    cone_slope_[i].setZero(c.count, c.count);
    cones_.push_back(static_cast<int>(i));
    nodes_[c.node].cones = true;
  }
  new_slope_.resize(most, most);
  new_outside_.resize(most);
  weight_.resize(most);
  difference_.resize(most);
}

void HorizonConstraints::find_runs() {
  const int count = problem_.constraint_rows();
  limit_ = Eigen::VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  lower_ = -limit_;
  upper_ = limit_;
  term_.assign(count, -1);
  enum Kind { kNone, kCone, kBounds, kConeCost, kBoundsCost };
  std::vector<Kind> kind(count, kNone);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Rows& c = rows_[i];
    const bool cone = c.lower == nullptr;
    const Kind own = c.cost ? (cone ? kConeCost : kBoundsCost) : cone ? kCone : kBounds;
    std::fill_n(kind.begin() + c.row, c.count, own);
    std::fill_n(term_.begin() + c.row, c.count, static_cast<int>(i));
    if (!cone && std::isfinite(c.limit)) soft_.push_back(static_cast<int>(i));
  }
  const auto add_runs = [&](std::vector<Run>& runs, bool cost, auto wanted) {
    for (int row = 0; row < count; ++row) {
      if (!wanted(kind[row])) continue;
      if (row == 0 || !wanted(kind[row - 1])) runs.push_back({row, 0, cost});
      ++runs.back().count;
    }
  };
  add_runs(bounds_, false, [](Kind k) { return k == kBounds; });
  add_runs(bounds_, true, [](Kind k) { return k == kBoundsCost; });
  add_runs(augmented_, false, [](Kind k) { return k == kBounds || k == kCone; });
}

void HorizonConstraints::read_bounds() {
  for (const Rows& c : rows_) {
    if (c.lower == nullptr) continue;
    std::copy_n(c.lower, c.count, lower_.data() + c.row);
    std::copy_n(c.upper, c.count, upper_.data() + c.row);
  }
}

/// Constraints come first among the rows, in their order.
void HorizonConstraints::read_limits() {
  for (std::size_t i = 0; i < problem_.constraints().size(); ++i)
    rows_[i].limit = problem_.constraints()[i].limit;
}

void HorizonConstraints::read_weights() {
  for (const Rows& c : rows_) {
    if (!c.cost) continue;
    const KnotView& knot = problem_.knot(c.node);
    const double weight = knot.cost_scale * knot.parameters[c.weight];
    for (int r = 0; r < c.count; ++r)
      penalty_[c.row + r] = c.factors == nullptr ? weight : weight * c.factors[r];
  }
}

void HorizonConstraints::reset() {
  settled_ = false;
  read_bounds();
  read_limits();
  read_weights();
}

/// Adds constraints that are soft by the square of their distance.
void HorizonConstraints::add_soft_costs() {
  for (const NodeConstraint& c : problem_.soft_constraints())
    if (c.term->softness == Softness::l2 && !c.term->grows_with)
      add_cost({c.node, c.row, c.term->rows, c.lower, c.upper, kUnlimited, true, c.term->weight()});
}

void HorizonConstraints::add_barriers(int node) {
  for (const CostTerm& cost : problem_.knot(node).model->costs()) {
    if (!cost.is_barrier() || cost.grows_with) continue;
    const Activation& barrier = cost.activation;
    add_cost({node, problem_.constraint_offset(node) + cost.row, cost.residual->size(),
              barrier.lower.data(), barrier.upper.data(), kUnlimited, true, cost.weight,
              barrier.weights.empty() ? nullptr : barrier.weights.data()});
  }
}

/// Adds a term of constant penalty.
void HorizonConstraints::add_cost(const Rows& cost) {
  const KnotView& knot = problem_.knot(cost.node);
  if (knot.cost_scale * knot.parameters[cost.weight] == 0) return;
  rows_.push_back(cost);
}

void HorizonConstraints::start(const Linearization& linearization,
                               const Augmentation* augmentation) {
  base_ = linearization.constraint;
  if (augmentation != nullptr) read_augmentation(*augmentation);
  for (Node& node : nodes_) node.changed = false;
  restart();
}

void HorizonConstraints::read_augmentation(const Augmentation& augmentation) {
  for (const Run& run : augmented_) {
    penalty_.segment(run.row, run.count) = augmentation.penalty.segment(run.row, run.count);
    base_.segment(run.row, run.count) += augmentation.shift.segment(run.row, run.count);
  }
  for (const int i : soft_)
    limit_.segment(rows_[i].row, rows_[i].count)
        .setConstant(rows_[i].limit / penalty_[rows_[i].row]);
}

void HorizonConstraints::restart() {
  around_ = base_;
  for (const int i : cones_) {
    const Rows& c = rows_[i];
    outside_cone_at(c, base_.data() + c.row, c.limit / penalty_[c.row], outside_.data() + c.row,
                    cone_slope_[i].data());
  }
  for (const Run& run : bounds_)
    for_each_lane(run.count, [&](auto kind, int r) {
      const int row = run.row + r;
      const auto s = load_rows<decltype(kind)>(base_.data() + row);
      store_rows(outside_.data() + row, outside_rows(row, s));
      store_rows(slope_.data() + row, row_slopes(row, s, run.cost));
    });
}

/// values ← g + ∂g z + ν/ρ of all rows.
void HorizonConstraints::shift(const std::vector<Eigen::VectorXd>& z,
                               const Linearization& linearization, Eigen::VectorXd& values) const {
  values = base_;
  for (int k = 0; k <= problem_.knots(); ++k) {
    if (nodes_[k].terms.empty()) continue;
    const Eigen::MatrixXd& C = linearization.knots[k].C;
    multiply_add(C, z[k].data(), values.data() + problem_.constraint_offset(k));
  }
}

int HorizonConstraints::revise(const std::vector<Eigen::VectorXd>& z, double allowed,
                               Linearization& linearization, std::optional<int>& last) {
  shift(z, linearization, shifted_);
  find_error();
  return error_ <= allowed ? 0 : revise(linearization, last);
}

/// found_ ← P(s) at shifted_, error_ ← Σ ρ |P(s) − model|². Marks the bound terms with an
/// inaccurate model, and their nodes and those of cones.
void HorizonConstraints::find_error() {
  allowed_ = kExact * outside_.lpNorm<Eigen::Infinity>();
  std::fill(off_.begin(), off_.end(), false);
  for (Node& node : nodes_) node.off = node.cones;
  error_ = 0;
  for (const Run& run : bounds_) error_ += find_bounds_error(run);
  for (const int i : cones_) error_ += find_cone_error(i);
}

double HorizonConstraints::find_bounds_error(const Run& run) {
  double sum = 0;
  for_each_lane(run.count, [&](auto kind, int r) {
    using S = decltype(kind);
    const int row = run.row + r;
    const S found = outside_rows(row, load_rows<S>(shifted_.data() + row));
    store_rows(found_.data() + row, found);
    // Most rows are inactive and stay so.
    const S zero(0.0), outside = load_rows<S>(outside_.data() + row);
    if (any((!(found == zero)) | (!(outside == zero)) |
            (!(load_rows<S>(slope_.data() + row) == zero))))
      sum += find_rows_error(row, found);
  });
  return sum;
}

/// Error of one row with P found there, or of a lane of rows.
template <class S>
inline double HorizonConstraints::find_rows_error(int row, const S& found) {
  constexpr int kCount = sizeof(S) / sizeof(double);
  const S outside = load_rows<S>(outside_.data() + row), slope = load_rows<S>(slope_.data() + row);
  const S moved = load_rows<S>(shifted_.data() + row) - load_rows<S>(around_.data() + row);
  double off[kCount], error[kCount], sum = 0;
  store_rows(off, abs(found - (outside + slope * moved)));
  store_rows(error, found - outside - slope * moved);
  for (int i = 0; i < kCount; ++i) {
    sum += penalty_[row + i] * error[i] * error[i];
    if (off[i] <= allowed_) continue;
    const int term = term_[row + i];
    off_[term] = nodes_[rows_[term].node].off = true;
  }
  return sum;
}

double HorizonConstraints::find_cone_error(int term) {
  const Rows& c = rows_[term];
  const int n = c.count;
  outside_cone_at(c, shifted_.data() + c.row, c.limit / penalty_[c.row], found_.data() + c.row,
                  nullptr);
  auto error = weight_.head(n);
  auto moved = new_outside_.head(n);
  moved = shifted_.segment(c.row, n) - around_.segment(c.row, n);
  error = found_.segment(c.row, n) - outside_.segment(c.row, n);
  error.noalias() -= cone_slope_[term] * moved;
  return penalty_[c.row] * error.squaredNorm();
}

/// Revises the model around shifted_, with P found_ there. To be called after find_error().
int HorizonConstraints::revise(Linearization& linearization, std::optional<int>& last) {
  int changes = 0;
  for (int k = 0; k <= problem_.knots(); ++k) {
    Node& node = nodes_[k];
    if (!node.off) continue;
    for (const int i : node.terms) {
      const Rows& c = rows_[i];
      const bool changed = c.lower == nullptr
                               ? revise_cone(c, i, linearization.knots[k], node)
                               : off_[i] && revise_bounds(c, linearization.knots[k], node);
      if (!changed) continue;
      ++changes;
      last = k;
    }
    if (!update_.empty()) update_.apply(linearization.knots[k].hessian);
  }
  return changes;
}

void HorizonConstraints::expect(Linearization& linearization) {
  if (!settled_) return;
  settled_ = false;
  // Multipliers stay roughly the same for any penalty.
  shifted_ = inside_;
  for (int row = 0; row < shifted_.size(); ++row)
    if (multiplier_[row] != 0) shifted_[row] += multiplier_[row] / penalty_[row];
  find_error();
  std::optional<int> last;
  revise(linearization, last);
}

void HorizonConstraints::settle() {
  inside_ = shifted_ - found_;
  multiplier_ = found_.cwiseProduct(penalty_);
  settled_ = true;
}

bool HorizonConstraints::revise_bounds(const Rows& c, KnotLinearization& knot, Node& node) {
  const int offset = problem_.constraint_offset(c.node);
  bool changed = false;
  for (int r = 0; r < c.count; ++r) {
    const int row = c.row + r;
    const double s = shifted_[row], rho = penalty_[row];
    const double outside = found_[row];
    const double model = outside_[row] + slope_[row] * (s - around_[row]);
    if (rho == 0 || std::abs(outside - model) <= allowed_) continue;
    keep(knot, node);
    changed = true;
    const double slope = row_slopes(row, s, c.cost);
    const double before = outside_[row] - slope_[row] * (around_[row] - base_[row]);
    const double after = outside - slope * (s - base_[row]);
    const auto C = knot.C.row(row - offset);
    knot.gradient += rho * (after - before) * C.transpose();
    if (slope != slope_[row]) update_.add(C, rho * (slope - slope_[row]));
    outside_[row] = outside;
    slope_[row] = slope;
    around_[row] = s;
  }
  return changed;
}

bool HorizonConstraints::revise_cone(const Rows& c, int index, KnotLinearization& knot,
                                     Node& node) {
  const int n = c.count;
  const auto s = shifted_.segment(c.row, n);
  auto around = around_.segment(c.row, n);
  auto outside = outside_.segment(c.row, n);
  Eigen::MatrixXd& slope = cone_slope_[index];
  auto new_outside = new_outside_.head(n);
  const double rho = penalty_[c.row], limit = c.limit / rho;
  new_outside = found_.segment(c.row, n);
  auto error = weight_.head(n);
  auto difference = difference_.head(n);
  error = new_outside - outside;
  difference = s - around;
  error.noalias() -= slope * difference;
  const double allowed = std::max(allowed_, kConeShare * new_outside.norm());
  if (error.norm() <= allowed) return false;
  keep(knot, node);
  Eigen::Map<Eigen::MatrixXd> new_slope(new_slope_.data(), n, n);
  outside_cone_at(c, s.data(), limit, new_outside.data(), new_slope.data());
  const auto base = base_.segment(c.row, n);
  auto weight = weight_.head(n);
  weight = new_outside - outside;
  difference = s - base;
  weight.noalias() -= new_slope * difference;
  difference = around - base;
  weight.noalias() += slope * difference;
  const auto C = knot.C.middleRows(c.row - problem_.constraint_offset(c.node), n);
  knot.gradient.noalias() += rho * (C.transpose() * weight);
  slope = rho * (new_slope - slope);
  update_.add(C, slope);
  slope = new_slope;
  outside = new_outside;
  around = s;
  return true;
}

void HorizonConstraints::set_path(const std::vector<Eigen::VectorXd>& z,
                                  const std::vector<Eigen::VectorXd>& to,
                                  const Linearization& linearization) {
  shift(z, linearization, shifted_);
  shift(to, linearization, along_);
  along_ -= shifted_;
}

double HorizonConstraints::slope_beyond_model(double alpha) {
  double sum = 0;
  for (std::size_t i = 0; i < cone_slope_.size(); ++i) {
    const Rows& c = rows_[i];
    const int n = c.count;
    const double rho = penalty_[c.row], limit = c.limit / rho;
    if (c.lower != nullptr) {
      for (int row = c.row; row < c.row + n; ++row) {
        const double s = shifted_[row] + alpha * along_[row];
        const double model = outside_[row] + slope_[row] * (s - around_[row]);
        sum += penalty_[row] * (outside_rows(row, s) - model) * along_[row];
      }
      continue;
    }
    const auto along = along_.segment(c.row, n);
    auto s = weight_.head(n);
    auto outside = new_outside_.head(n);
    s = shifted_.segment(c.row, n) + alpha * along;
    outside_cone_at(c, s.data(), limit, outside.data(), nullptr);
    outside -= outside_.segment(c.row, n);
    s -= around_.segment(c.row, n);
    outside.noalias() -= cone_slope_[i] * s;
    sum += rho * outside.dot(along);
  }
  return sum;
}

void HorizonConstraints::keep(const Linearization& linearization) {
  for (std::size_t k = 0; k < nodes_.size(); ++k) keep(linearization.knots[k], nodes_[k]);
}

void HorizonConstraints::keep(const KnotLinearization& knot, Node& node) {
  if (node.changed) return;
  node.gradient = knot.gradient;
  node.hessian = knot.hessian();
  node.changed = true;
}

bool HorizonConstraints::restore(Linearization& linearization) {
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

void HorizonConstraints::exchange_memory(HorizonConstraints& other) {
  for (std::size_t k = 0; k < std::min(nodes_.size(), other.nodes_.size()); ++k)
    exchange(nodes_[k].hessian, other.nodes_[k].hessian);
}

}  // namespace conddp
