#include "solvers/interior/interior_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Distance of the first iterate from its bounds, relative to them and to their width (Wächter,
/// Biegler 2006, section 3.6).
constexpr double kInside = 1e-2;
/// Penalty ρ of equalities, in multiples of the size of the costs' derivatives: six of sixteen
/// digits, so that steps satisfy equations to six digits and keep ten.
constexpr double kPenalty = 1e6;
/// Share of the curvature of a pair's own terms that the product's may use up.
constexpr double kPairShare = 0.9;
/// A step leaves this share of slacks and multipliers at least (Wächter, Biegler 2006).
constexpr double kLeftAtMost = 0.01;
/// A multiplier stays within this factor of μ/s (Wächter, Biegler 2006, equation 16).
constexpr double kCentral = 1e10;

/// Shortens a length so that v + length · d keeps a share of v.
void limit(double v, double d, double share, double& length) {
  if (d < 0) length = std::min(length, -(1 - share) * v / d);
}

}  // namespace

ScalarTerm ScalarTerm::row(const NodeConstraint& constraint, int row) {
  int first = 0;
  for (const RowBlock& block : constraint.term->blocks) {
    if (row < first + block.rows)
      return {constraint.node, constraint.row + row, -1, &block.columns};
    first += block.rows;
  }
  return {constraint.node, constraint.row + row, -1, &constraint.term->blocks.back().columns};
}

ScalarTerm ScalarTerm::control(int node, int entry) { return {node, entry, -1, nullptr}; }

ScalarTerm ScalarTerm::product(int node, int first, int second) {
  return {node, first, second, nullptr};
}

double ScalarTerm::value(const TermPoint& at) const {
  if (columns_ != nullptr) return at.rows[index_];
  const auto u = at.trajectory.u(node_);
  return partner_ < 0 ? u[index_] : u[index_] * u[partner_];
}

/// Calls use(column of z, derivative) for every entry of ∂g/∂z.
template <class Use>
void ScalarTerm::for_each_entry(const ShootingProblem& problem, const Linearization& linearization,
                                const Trajectory& at, Use use) const {
  const int ndx = problem.ndx();
  if (columns_ != nullptr) {
    const auto& C = linearization.knots[node_].C;
    const int r = index_ - problem.constraint_offset(node_);
    for (const int column : *columns_) use(column, C(r, column));
  } else if (partner_ < 0) {
    use(ndx + index_, 1.0);
  } else {
    const auto u = at.u(node_);
    use(ndx + index_, u[partner_]);
    use(ndx + partner_, u[index_]);
  }
}

double ScalarTerm::slope(const ShootingProblem& problem, const Linearization& linearization,
                         const Trajectory& at, const LinearRollout& step) const {
  double sum = 0;
  const Eigen::VectorXd& z = step.z(node_);
  for_each_entry(problem, linearization, at,
                 [&](int column, double derivative) { sum += derivative * z[column]; });
  return sum;
}

void ScalarTerm::add_gradient(const ShootingProblem& problem, const Trajectory& at, double factor,
                              Linearization& to) const {
  Eigen::VectorXd& gradient = to.knots[node_].gradient;
  for_each_entry(problem, to, at,
                 [&](int column, double derivative) { gradient[column] += factor * derivative; });
}

void ScalarTerm::add_square(const ShootingProblem& problem, const Trajectory& at, double factor,
                            Linearization& to) const {
  Eigen::MatrixXd& H = to.knots[node_].hessian.change();
  for_each_entry(problem, to, at, [&](int i, double derivative) {
    const double scaled = factor * derivative;
    for_each_entry(problem, to, at, [&](int j, double other) { H(j, i) += scaled * other; });
  });
}

bool InteriorTerms::Side::is_soft() const { return limit < kInfinity; }

InteriorTerms::InteriorTerms(const ShootingProblem& problem, const ControlBounds& bounds)
    : problem_(problem), bounds_(bounds) {
  for (const NodeConstraint& c : problem.constraints())
    c.term->has_pairs() ? collect_pairs(c) : collect(c);
  collect_bounds(bounds);
  saved_ = sides_;
  equalities_.reserve(equalities_.size() + pairs_.size());
}

void InteriorTerms::collect(const NodeConstraint& c) {
  if (c.limit == 0) return;  // its multipliers vanish
  if (c.term->is_cone()) {
    cones_.emplace_back(c);
    return;
  }
  for (int r = 0; r < c.term->rows; ++r) {
    const ScalarTerm term = ScalarTerm::row(c, r);
    if (c.lower[r] == c.upper[r] && !c.is_soft()) {
      equalities_.push_back({term, c.lower[r]});
      continue;
    }
    if (std::isfinite(c.lower[r])) sides_.push_back({term, 1, c.lower[r], c.limit});
    if (std::isfinite(c.upper[r])) sides_.push_back({term, -1, c.upper[r], c.limit});
  }
}

/// The rows of pairs are entries of the control.
void InteriorTerms::collect_pairs(const NodeConstraint& c) {
  std::vector<int> entries;
  for (const RowBlock& block : c.term->blocks)
    entries.insert(entries.end(), block.rows, block.columns.front() - problem_.ndx());
  for (int r = 0; r < c.term->rows; r += 2) {
    const int first = entries[r], second = entries[r + 1], side = static_cast<int>(sides_.size());
    pairs_.push_back({c.node, c.row + r, first, second, side});
    sides_.push_back({ScalarTerm::product(c.node, first, second), -1, 0, kInfinity});
    sides_.push_back({ScalarTerm::control(c.node, first), 1, 0, kInfinity});
    sides_.push_back({ScalarTerm::control(c.node, second), 1, 0, kInfinity});
  }
}

void InteriorTerms::collect_bounds(const ControlBounds& bounds) {
  for (int k = 0; k < problem_.knots(); ++k)
    for (int i = 0; i < problem_.nu(k); ++i) {
      const double lower = bounds.lower(k)[i], upper = bounds.upper(k)[i];
      const ScalarTerm term = ScalarTerm::control(k, i);
      if (lower == upper) {
        equalities_.push_back({term, lower});
        continue;
      }
      if (std::isfinite(lower)) sides_.push_back({term, 1, lower, kInfinity});
      if (std::isfinite(upper)) sides_.push_back({term, -1, upper, kInfinity});
    }
}

void InteriorTerms::enter(Trajectory& trajectory) const {
  for (const Pair& pair : pairs_)
    for (const int entry : {pair.first, pair.second}) {
      double& v = trajectory.u(pair.node)[entry];
      v = std::max(v, kInside);
    }
  for (int k = 0; k < problem_.knots(); ++k)
    for (int i = 0; i < problem_.nu(k); ++i) {
      const double lower = bounds_.lower(k)[i], upper = bounds_.upper(k)[i];
      const auto distance = [&](double bound) {
        return kInside * std::min(std::max(1.0, std::abs(bound)), upper - lower);
      };
      double& v = trajectory.u(k)[i];
      if (std::isfinite(lower)) v = std::max(v, lower + distance(lower));
      if (std::isfinite(upper)) v = std::min(v, upper - distance(upper));
    }
}

double InteriorTerms::value(const Side& side, const TermPoint& at) const {
  const bool is_product = !side.term.is_control() && side.term.row() < 0;
  return side.sign * (side.term.value(at) - (is_product ? relaxation_ : side.bound));
}

void InteriorTerms::start(const TermPoint& at, double barrier, double relaxation, double scale) {
  barrier_ = barrier;
  relaxation_ = relaxation;
  scale_ = scale;
  penalty_ = kPenalty * scale;
  for (Pair& pair : pairs_) {
    if (pair.fixed >= 0) equalities_.pop_back();
    pair.fixed = -1;
  }
  for (Equality& e : equalities_) e.y = 0;
  for (Side& side : sides_) {
    side.active = true;
    const double distance = value(side, at);
    side.s = side.term.is_control()
                 ? distance
                 : std::max(distance, kInside * std::max(1.0, std::abs(side.bound)));
    side.nu = mu() / side.s;
    side.p = side.q = 0;
    if (!side.is_soft()) continue;
    side.nu = std::min(side.nu, 0.5 * side.limit);
    side.q = side.limit - side.nu;
    side.p = mu() / side.q;
  }
  for (InteriorCone& cone : cones_) cone.start(at.rows, mu());
}

void InteriorTerms::hold_pairs(Trajectory& trajectory) {
  relaxation_ = 0;
  for (Pair& pair : pairs_) {
    auto u = trajectory.u(pair.node);
    pair.holds_first = u[pair.first] < u[pair.second];
    const int held = pair.holds_first ? pair.first : pair.second;
    Side &product = sides_[pair.side], &bound = sides_[pair.side + (pair.holds_first ? 1 : 2)];
    pair.fixed = static_cast<int>(equalities_.size());
    const double other = u[pair.holds_first ? pair.second : pair.first];
    equalities_.push_back({ScalarTerm::control(pair.node, held), 0});
    equalities_.back().y = product.nu * other - bound.nu;
    product.active = bound.active = false;
    u[held] = 0;
  }
}

void InteriorTerms::write_row_multipliers(Eigen::VectorXd& multipliers) const {
  multipliers.setZero();
  for (const Equality& e : equalities_)
    if (e.term.row() >= 0) multipliers[e.term.row()] += e.y;
  for (const Side& side : sides_)
    if (side.term.row() >= 0) multipliers[side.term.row()] -= side.sign * side.nu;
  for (const InteriorCone& cone : cones_) cone.write_multipliers(multipliers);
}

void InteriorTerms::add_multipliers(const Trajectory& at, Linearization& to) const {
  for (const Equality& e : equalities_)
    if (e.term.row() < 0) e.term.add_gradient(problem_, at, e.y, to);
  for (const Side& side : sides_)
    if (side.active && side.term.row() < 0)
      side.term.add_gradient(problem_, at, -side.sign * side.nu, to);
}

void InteriorTerms::write_multipliers(const Trajectory& at, Eigen::VectorXd& multipliers) const {
  write_row_multipliers(multipliers);
  for (const Pair& pair : pairs_) {
    const auto u = at.u(pair.node);
    const auto of = [&](int side) { return sides_[side].active ? sides_[side].nu : 0.0; };
    multipliers[pair.row] = of(pair.side) * u[pair.second] - of(pair.side + 1);
    multipliers[pair.row + 1] = of(pair.side) * u[pair.first] - of(pair.side + 2);
    if (pair.fixed >= 0)
      multipliers[pair.row + (pair.holds_first ? 0 : 1)] += equalities_[pair.fixed].y;
  }
}

/// Prepares the elimination of a side: a step along g changes ν by (push − ν σ ∂g·δz)/width.
void InteriorTerms::prepare(Side& side) const {
  const double elastic = side.is_soft() ? mu() / side.q - side.p : 0;
  side.width = side.s + (side.is_soft() ? side.nu * side.p / side.q : 0);
  side.push = mu() - side.s * side.nu - side.nu * (side.residual + elastic);
}

void InteriorTerms::measure(const TermPoint& at) {
  for (Equality& e : equalities_) e.residual = e.term.value(at) - e.target;
  for (Side& side : sides_)
    if (side.active) side.residual = value(side, at) + side.p - side.s;
  for (InteriorCone& cone : cones_) cone.measure(at.rows);
}

void InteriorTerms::add_gradients(const Trajectory& at, Linearization& to) {
  for (const Equality& e : equalities_)
    e.term.add_gradient(problem_, at, penalty_ * e.residual, to);
  for (Side& side : sides_) {
    if (!side.active) continue;
    prepare(side);
    side.term.add_gradient(problem_, at, -side.sign * side.push / side.width, to);
  }
  for (InteriorCone& cone : cones_) cone.add_gradient(problem_, mu(), to);
}

void InteriorTerms::add_hessians(const Trajectory& at, Linearization& to) {
  for (const Equality& e : equalities_) e.term.add_square(problem_, at, penalty_, to);
  for (const Side& side : sides_)
    if (side.active) side.term.add_square(problem_, at, side.nu / side.width, to);
  for (InteriorCone& cone : cones_) cone.add_hessian(problem_, to);
}

void InteriorTerms::add_pair_curvature(const Trajectory& at, bool convex, Linearization& to) const {
  for (const Pair& pair : pairs_) {
    const Side& product = sides_[pair.side];
    if (!product.active) continue;
    double curvature = product.nu;
    if (convex) {
      const auto u = at.u(pair.node);
      const double z = u[pair.first], s = u[pair.second], h = product.nu / product.width;
      const auto own = [&](int side) { return sides_[side].nu / sides_[side].width; };
      const double zz = own(pair.side + 1) + h * s * s, ss = own(pair.side + 2) + h * z * z;
      curvature = std::min(curvature, kPairShare * (std::sqrt(zz * ss) - h * z * s));
    }
    Eigen::MatrixXd& H = to.knots[pair.node].hessian.change();
    const int i = problem_.ndx() + pair.first, j = problem_.ndx() + pair.second;
    H(i, j) += curvature;
    H(j, i) += curvature;
  }
}

StepLimits InteriorTerms::expand(const Linearization& linearization, const Trajectory& at,
                                 const LinearRollout& step) {
  StepLimits limits;
  const double left = std::min(kLeftAtMost, barrier_);
  for (Equality& e : equalities_) {
    e.along = e.term.slope(problem_, linearization, at, step);
    e.dy = penalty_ * (e.residual + e.along);
  }
  for (Side& side : sides_) {
    if (!side.active) continue;
    side.along = side.sign * side.term.slope(problem_, linearization, at, step);
    side.dnu = (side.push - side.nu * side.along) / side.width;
    side.dp = side.is_soft() ? (mu() - side.p * side.q + side.p * side.dnu) / side.q : 0;
    side.ds = side.along + side.dp + side.residual;
    limit(side.s, side.ds, left, limits.primal);
    limit(side.nu, side.dnu, left, limits.dual);
    if (!side.is_soft()) continue;
    limit(side.p, side.dp, left, limits.primal);
    limit(side.q, -side.dnu, left, limits.dual);
  }
  for (InteriorCone& cone : cones_) cone.expand(problem_, linearization, step, left, limits);
  return limits;
}

double InteriorTerms::barrier_slope(double slope) const {
  for (const Equality& e : equalities_) slope -= e.y * e.along;
  for (const Side& side : sides_) {
    if (!side.active) continue;
    slope += side.nu * side.along - mu() * side.ds / side.s;
    if (side.is_soft()) slope += side.limit * side.dp - mu() * side.dp / side.p;
  }
  for (const InteriorCone& cone : cones_) slope += cone.barrier_slope(mu());
  return slope;
}

void InteriorTerms::save() {
  saved_ = sides_;
  for (InteriorCone& cone : cones_) cone.save();
}

void InteriorTerms::restore() {
  sides_ = saved_;
  for (InteriorCone& cone : cones_) cone.restore();
}

void InteriorTerms::move(double length, const Trajectory& trial) {
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    Side& side = sides_[i];
    if (!side.active) continue;
    side.s = side.term.is_control()
                 ? side.sign * (trial.u(side.term.node())[side.term.entry()] - side.bound)
                 : saved_[i].s + length * side.ds;
    side.p = saved_[i].p + length * side.dp;
  }
  for (InteriorCone& cone : cones_) cone.move(length);
}

void InteriorTerms::accept(double primal, double dual) {
  for (Equality& e : equalities_) e.y += primal * e.dy;
  for (Side& side : sides_) {
    if (!side.active) continue;
    side.nu += dual * side.dnu;
    if (side.is_soft())
      side.q = side.limit - side.nu;
    else
      side.nu = std::clamp(side.nu, mu() / (kCentral * side.s), kCentral * mu() / side.s);
  }
  for (InteriorCone& cone : cones_) cone.accept(dual);
}

double InteriorTerms::barrier_function(double cost) const {
  for (const Side& side : sides_) {
    if (!side.active) continue;
    cost -= mu() * std::log(side.s);
    if (side.is_soft()) cost += side.limit * side.p - mu() * std::log(side.p);
  }
  for (const InteriorCone& cone : cones_) cost += cone.barrier_function(mu());
  return cost;
}

double InteriorTerms::infeasibility(const TermPoint& at) const {
  double sum = 0;
  for (const Equality& e : equalities_) sum += std::abs(e.term.value(at) - e.target);
  for (const Side& side : sides_)
    if (side.active && !side.term.is_control()) sum += std::abs(value(side, at) + side.p - side.s);
  for (const InteriorCone& cone : cones_) sum += cone.infeasibility(at.rows);
  return sum;
}

double InteriorTerms::largest_residual(double size) const {
  double largest = 0;
  for (const Equality& e : equalities_) largest = std::max(largest, std::abs(e.residual));
  for (const Side& side : sides_) {
    if (!side.active) continue;
    largest =
        std::max({largest, std::abs(side.residual), std::abs(side.s * side.nu - mu()) / size});
    if (side.is_soft()) largest = std::max(largest, std::abs(side.p * side.q - mu()) / size);
  }
  for (const InteriorCone& cone : cones_)
    largest = std::max(largest, cone.largest_residual(mu(), size));
  return largest;
}

double InteriorTerms::mean_multiplier() const {
  double sum = 0;
  for (const Equality& e : equalities_) sum += std::abs(e.y);
  for (const Side& side : sides_) sum += side.active ? side.nu : 0;
  for (const InteriorCone& cone : cones_) sum += cone.multiplier_sum();
  return sum / std::max<std::size_t>(1, equalities_.size() + sides_.size() + cones_.size());
}

void InteriorTerms::snap(Trajectory& trajectory) const {
  for (const Side& side : sides_)
    if (side.active && side.term.is_control() && side.s * scale_ < side.nu)
      trajectory.u(side.term.node())[side.term.entry()] = side.bound;
}

}  // namespace conddp
