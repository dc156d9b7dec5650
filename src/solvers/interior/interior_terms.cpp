#include "solvers/interior/interior_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace conddp {
namespace {

using namespace tuning::interior;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kZero{};  ///< bound of the entries of pairs

/// Shortens a length so that v + length · d keeps a share of v.
void limit(double v, double d, double share, double& length) {
  if (d < 0) length = std::min(length, -(1 - share) * v / d);
}

}  // namespace

double ScalarTerm::value(const TermPoint& at) const {
  if (row_ >= 0) return at.rows[row_];
  const auto u = at.trajectory.u(node_);
  return is_product() ? u[entry_] * u[partner_] : u[entry_];
}

double ScalarTerm::slope(const Eigen::VectorXd& rows, const Trajectory& at,
                         const LinearRollout& step) const {
  if (row_ >= 0) return rows[row_];
  const auto u = at.u(node_);
  const auto du = step.du(node_);
  return is_product() ? u[partner_] * du[entry_] + u[entry_] * du[partner_] : du[entry_];
}

void ScalarTerm::add_gradient(const Trajectory& at, double factor, Eigen::VectorXd& rows,
                              Linearization& to) const {
  if (row_ >= 0) {
    rows[row_] += factor;
    return;
  }
  const auto u = at.u(node_);
  auto gradient = to.knots[node_].gradient.tail(u.size());
  gradient[entry_] += is_product() ? factor * u[partner_] : factor;
  if (is_product()) gradient[partner_] += factor * u[entry_];
}

void ScalarTerm::add_square(const Trajectory& at, double factor, Eigen::VectorXd& rows,
                            std::vector<Eigen::MatrixXd>& to) const {
  if (row_ >= 0) {
    rows[row_] += factor;
    return;
  }
  const auto u = at.u(node_);
  auto H = to[node_].bottomRightCorner(u.size(), u.size());
  if (!is_product()) {
    H(entry_, entry_) += factor;
    return;
  }
  const double a = u[partner_], b = u[entry_];
  H(entry_, entry_) += factor * a * a;
  H(partner_, partner_) += factor * b * b;
  H(std::max(entry_, partner_), std::min(entry_, partner_)) += factor * a * b;
}

bool InteriorTerms::Side::is_soft() const { return limit < kInfinity; }

InteriorTerms::InteriorTerms(const ShootingProblem& problem, const ControlBounds& bounds)
    : problem_(problem),
      bounds_(bounds),
      rows_(problem),
      factors_(Eigen::VectorXd::Zero(problem.constraint_rows())),
      along_(factors_) {
  for (int k = 0; k <= problem.knots(); ++k) {
    const int nz = problem.knot(k).model->nz();
    condensed_.push_back(Eigen::MatrixXd::Zero(nz, nz));
  }
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
    const ScalarTerm term = ScalarTerm::of_row(c.node, c.row + r);
    if (c.lower[r] == c.upper[r] && !c.is_soft()) {
      equalities_.push_back({term, c.lower + r});
      continue;
    }
    if (std::isfinite(c.lower[r])) sides_.push_back({term, 1, c.lower + r, &c.limit});
    if (std::isfinite(c.upper[r])) sides_.push_back({term, -1, c.upper + r, &c.limit});
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
    sides_.push_back({ScalarTerm::product(c.node, first, second), -1, &kZero, &kInfinity});
    sides_.push_back({ScalarTerm::control(c.node, first), 1, &kZero, &kInfinity});
    sides_.push_back({ScalarTerm::control(c.node, second), 1, &kZero, &kInfinity});
  }
}

void InteriorTerms::collect_bounds(const ControlBounds& bounds) {
  for (int k = 0; k < problem_.knots(); ++k)
    for (int i = 0; i < problem_.nu(k); ++i) {
      const double *lower = bounds.lower(k).data() + i, *upper = bounds.upper(k).data() + i;
      const ScalarTerm term = ScalarTerm::control(k, i);
      if (*lower == *upper) {
        equalities_.push_back({term, lower});
        continue;
      }
      if (std::isfinite(*lower)) sides_.push_back({term, 1, lower, &kInfinity});
      if (std::isfinite(*upper)) sides_.push_back({term, -1, upper, &kInfinity});
    }
}

void InteriorTerms::enter(Trajectory& trajectory, double inside) const {
  for (const Pair& pair : pairs_)
    for (const int entry : {pair.first, pair.second}) {
      double& v = trajectory.u(pair.node)[entry];
      v = std::max(v, inside);
    }
  for (int k = 0; k < problem_.knots(); ++k)
    for (int i = 0; i < problem_.nu(k); ++i) {
      const double lower = bounds_.lower(k)[i], upper = bounds_.upper(k)[i];
      const auto distance = [&](double bound) {
        return inside * std::min(std::max(1.0, std::abs(bound)), upper - lower);
      };
      double& v = trajectory.u(k)[i];
      if (std::isfinite(lower)) v = std::max(v, lower + distance(lower));
      if (std::isfinite(upper)) v = std::min(v, upper - distance(upper));
    }
}

double InteriorTerms::value(const Side& side, const TermPoint& at) const {
  return side.sign * (side.term.value(at) - (side.term.is_product() ? relaxation_ : side.bound));
}

void InteriorTerms::start(const TermPoint& at, double mu, double relaxation, double inside) {
  mu_ = mu;
  relaxation_ = relaxation;
  for (Pair& pair : pairs_) {
    if (pair.fixed >= 0) equalities_.pop_back();
    pair.fixed = -1;
  }
  for (Equality& e : equalities_) {
    e.target = *e.target_now;
    e.y = 0;
  }
  for (Side& side : sides_) {
    side.bound = *side.bound_now;
    side.limit = *side.limit_now;
    side.active = true;
    const double distance = value(side, at);
    side.s = side.term.is_control()
                 ? distance
                 : std::max(distance, inside * std::max(1.0, std::abs(side.bound)));
    side.nu = mu_ / side.s;
    side.p = side.q = 0;
    if (!side.is_soft()) continue;
    side.nu = std::min(side.nu, kSoftShare * side.limit);
    side.q = side.limit - side.nu;
    side.p = mu_ / side.q;
  }
  for (InteriorCone& cone : cones_) cone.start(at.rows, mu_, inside);
}

void InteriorTerms::take_equation_multipliers(const Eigen::VectorXd& multipliers) {
  for (Equality& e : equalities_)
    if (e.term.row() >= 0) e.y = multipliers[e.term.row()];
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
    equalities_.push_back({ScalarTerm::control(pair.node, held), &kZero});
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

void InteriorTerms::add_multipliers(const Trajectory& at, Linearization& to) {
  for (const Equality& e : equalities_)
    if (e.term.row() < 0) e.term.add_gradient(at, e.y, factors_, to);
  for (const Side& side : sides_)
    if (side.active && side.term.row() < 0)
      side.term.add_gradient(at, -side.sign * side.nu, factors_, to);
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
  const double elastic = side.is_soft() ? mu_ / side.q - side.p : 0;
  side.width = side.s + (side.is_soft() ? side.nu * side.p / side.q : 0);
  side.push = mu_ - side.s * side.nu - side.nu * (side.residual + elastic);
}

void InteriorTerms::measure(const TermPoint& at) {
  for (Equality& e : equalities_) e.residual = e.term.value(at) - e.target;
  for (Side& side : sides_)
    if (side.active) side.residual = value(side, at) + side.p - side.s;
  for (InteriorCone& cone : cones_) cone.measure(at.rows);
}

void InteriorTerms::add_gradients(const Trajectory& at, Linearization& to) {
  factors_.setZero();
  for (const Equality& e : equalities_)
    e.term.add_gradient(at, penalty_ * e.residual, factors_, to);
  for (Side& side : sides_) {
    if (!side.active) continue;
    prepare(side);
    side.term.add_gradient(at, -side.sign * side.push / side.width, factors_, to);
  }
  rows_.add_gradients(factors_, to);
  for (InteriorCone& cone : cones_) cone.add_gradient(problem_, mu_, to);
}

void InteriorTerms::condense(const Trajectory& at, const Linearization& linearization) {
  factors_.setZero();
  for (Eigen::MatrixXd& H : condensed_) H.setZero();
  for (const Equality& e : equalities_) e.term.add_square(at, penalty_, factors_, condensed_);
  for (const Side& side : sides_)
    if (side.active) side.term.add_square(at, side.nu / side.width, factors_, condensed_);
  rows_.add_squares(factors_, linearization, condensed_);
  for (InteriorCone& cone : cones_)
    cone.add_hessian(problem_, linearization, condensed_[cone.node()]);
  for (Eigen::MatrixXd& H : condensed_) H.triangularView<Eigen::StrictlyUpper>() = H.transpose();
}

void InteriorTerms::add_hessians(const Trajectory& at, bool convex,
                                 std::vector<Eigen::MatrixXd>& to) const {
  for (std::size_t k = 0; k < to.size(); ++k) to[k] += condensed_[k];
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
    const int i = problem_.ndx() + pair.first, j = problem_.ndx() + pair.second;
    to[pair.node](i, j) += curvature;
    to[pair.node](j, i) += curvature;
  }
}

StepLimits InteriorTerms::expand(const Linearization& linearization, const Trajectory& at,
                                 const LinearRollout& step) {
  StepLimits limits;
  rows_.multiply(linearization, step.z(), along_);
  for (Equality& e : equalities_) {
    e.along = e.term.slope(along_, at, step);
    e.dy = penalty_ * (e.residual + e.along);
  }
  for (Side& side : sides_) {
    if (!side.active) continue;
    side.along = side.sign * side.term.slope(along_, at, step);
    side.dnu = (side.push - side.nu * side.along) / side.width;
    side.dp = side.is_soft() ? (mu_ - side.p * side.q + side.p * side.dnu) / side.q : 0;
    side.ds = side.along + side.dp + side.residual;
    limit(side.s, side.ds, kLeft, limits.primal);
    limit(side.nu, side.dnu, kLeft, limits.dual);
    if (!side.is_soft()) continue;
    limit(side.p, side.dp, kLeft, limits.primal);
    limit(side.q, -side.dnu, kLeft, limits.dual);
  }
  for (InteriorCone& cone : cones_) cone.expand(problem_, linearization, step, kLeft, limits);
  return limits;
}

double InteriorTerms::barrier_slope(double slope) const {
  for (const Equality& e : equalities_) slope -= e.y * e.along;
  for (const Side& side : sides_) {
    if (!side.active) continue;
    slope += side.nu * side.along - mu_ * side.ds / side.s;
    if (side.is_soft()) slope += side.limit * side.dp - mu_ * side.dp / side.p;
  }
  for (const InteriorCone& cone : cones_) slope += cone.barrier_slope(mu_);
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
      side.nu = std::clamp(side.nu, mu_ / (kCentral * side.s), kCentral * mu_ / side.s);
  }
  for (InteriorCone& cone : cones_) cone.accept(dual);
}

double InteriorTerms::barrier_function(double cost) const {
  for (const Side& side : sides_) {
    if (!side.active) continue;
    cost -= mu_ * std::log(side.s);
    if (side.is_soft()) cost += side.limit * side.p - mu_ * std::log(side.p);
  }
  for (const InteriorCone& cone : cones_) cost += cone.barrier_function(mu_);
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

double InteriorTerms::largest_residual() const {
  double largest = 0;
  for (const Equality& e : equalities_) largest = std::max(largest, std::abs(e.residual));
  for (const Side& side : sides_)
    if (side.active) largest = std::max(largest, std::abs(side.residual));
  for (const InteriorCone& cone : cones_) largest = std::max(largest, cone.largest_residual());
  return largest;
}

double InteriorTerms::off_center() const {
  double largest = 0;
  for (const Side& side : sides_) {
    if (!side.active) continue;
    largest = std::max(largest, std::abs(side.s * side.nu - mu_));
    if (side.is_soft()) largest = std::max(largest, std::abs(side.p * side.q - mu_));
  }
  for (const InteriorCone& cone : cones_) largest = std::max(largest, cone.off_center(mu_));
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
    if (side.active && side.term.is_control() && side.s < side.nu)
      trajectory.u(side.term.node())[side.term.entry()] = side.bound;
}

}  // namespace conddp
