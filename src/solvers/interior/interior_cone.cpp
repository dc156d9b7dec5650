#include "solvers/interior/interior_cone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

using Vector = Eigen::VectorXd;

using namespace tuning::interior;

/// s_n² − ‖s_t‖², where the last entry is s_n.
double determinant(const Vector& s) {
  const auto n = s.size() - 1;
  const double t = s.head(n).norm();
  return (s[n] - t) * (s[n] + t);
}

/// (−s_t, s_n)
void reflect(const Vector& s, Vector& to) {
  to = -s;
  to[s.size() - 1] = s[s.size() - 1];
}

/// Largest length along which quadratic a + 2 b α + c α² with a > 0 stays positive.
double positive_until(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (b >= 0 && c >= 0) return std::numeric_limits<double>::infinity();
  if (c > 0 && discriminant < 0) return std::numeric_limits<double>::infinity();
  return a / (-b + std::sqrt(std::max(0.0, discriminant)));
}

/// Largest length along which s + α d stays in the cone.
double in_cone_until(const Vector& s, const Vector& d) {
  const auto n = s.size() - 1;
  const double a = determinant(s), b = s[n] * d[n] - s.head(n).dot(d.head(n));
  const double c = determinant(d);
  double length = positive_until(a, b, c);
  if (d[n] < 0) length = std::min(length, -s[n] / d[n]);
  return length;
}

}  // namespace

InteriorCone::InteriorCone(const NodeConstraint& constraint)
    : constraint_(&constraint),
      n_(constraint.term->rows),
      factor_(Eigen::MatrixXd::Identity(n_, n_)) {
  for (Vector* v : {&s_, &nu_, &p_, &saved_s_, &saved_p_, &residual_, &push_, &along_, &ds_, &dnu_,
                    &dp_, &off_, &work_})
    *v = Vector::Zero(n_);
  for (Eigen::MatrixXd* m : {&P_, &inverse_}) *m = Eigen::MatrixXd::Zero(n_, n_);
  product_ = Eigen::MatrixXd::Zero(n_, constraint.term->blocks.front().columns.size());
}

bool InteriorCone::is_soft() const {
  return constraint_->limit < std::numeric_limits<double>::infinity();
}

void InteriorCone::start(const Vector& rows, double mu, double inside) {
  s_ = values(rows);
  const double t = s_.head(n_ - 1).norm();
  s_[n_ - 1] = std::max(s_[n_ - 1], t + inside * std::max(1.0, t));
  reflect(s_, nu_);
  nu_ *= mu / determinant(s_);
  p_.setZero();
  if (!is_soft()) return;
  const double w = constraint_->limit, size = nu_.norm();
  if (size > kSoftShare * w) nu_ *= kSoftShare * w / size;
  p_ = (2 * mu / (w * w - nu_.squaredNorm())) * nu_;
}

void InteriorCone::measure(const Vector& rows) { residual_ = values(rows) + p_ - s_; }

void InteriorCone::write_multipliers(Vector& multipliers) const {
  multipliers.segment(constraint_->row, n_) -= nu_;
}

/// Computes ∂p/∂ν and D⁻¹ = (W² + ∂p/∂ν)⁻¹, where W² ν = s (Nesterov, Todd 1997). W² = 2 η² w wᵀ −
/// η² J has the inverse 2 η⁻² (J w)(J w)ᵀ − η⁻² J, whose numbers do not cancel near the boundary.
void InteriorCone::scale(double mu) {
  const double det_s = determinant(s_), det_nu = determinant(nu_);
  const double root_s = std::sqrt(det_s), root_nu = std::sqrt(det_nu);
  const double gamma = std::sqrt(0.5 * (1 + s_.dot(nu_) / (root_s * root_nu)));
  reflect(nu_, work_);
  work_ = (s_ / root_s + work_ / root_nu) / (2 * gamma);
  const double eta2 = root_s / root_nu;
  const auto form = [this](const Vector& w, double size) {
    inverse_.noalias() = 2 * size * w * w.transpose();
    inverse_.diagonal().array() += size;
    inverse_(n_ - 1, n_ - 1) -= 2 * size;
  };
  if (!is_soft()) {
    reflect(work_, push_);
    form(push_, 1 / eta2);
    return;
  }
  form(work_, eta2);
  const double w = constraint_->limit, q = w * w - nu_.squaredNorm();
  // From q p = 2 μ ν with the present p, which is parallel to ν at a solution.
  const double along = std::max(0.0, p_.dot(nu_)) / nu_.squaredNorm();
  P_.noalias() = (2 * along / q) * nu_ * nu_.transpose();
  P_.diagonal().array() += 2 * mu / q;
  inverse_ += P_;
  factor_.compute(inverse_);
  inverse_.setIdentity();
  factor_.solveInPlace(inverse_);
}

void InteriorCone::add_gradient(const ShootingProblem& problem, double mu, Linearization& to) {
  scale(mu);
  reflect(nu_, push_);
  push_ *= mu / determinant(nu_);
  push_ -= s_;
  if (is_soft()) {
    const double w = constraint_->limit;
    off_ = (2 * mu / (w * w - nu_.squaredNorm())) * nu_ - p_;
  }
  push_ -= residual_ + off_;
  work_.noalias() = inverse_ * push_;
  KnotLinearization& knot = to.knots[node()];
  const int first = constraint_->row - problem.constraint_offset(node());
  for (const int column : constraint_->term->blocks.front().columns)
    knot.gradient[column] -= knot.C.col(column).segment(first, n_).dot(work_);
}

void InteriorCone::add_hessian(const ShootingProblem& problem, const Linearization& linearization,
                               Eigen::MatrixXd& to) {
  const KnotLinearization& knot = linearization.knots[node()];
  const int first = constraint_->row - problem.constraint_offset(node());
  const std::vector<int>& columns = constraint_->term->blocks.front().columns;
  const int count = static_cast<int>(columns.size());
  for (int j = 0; j < count; ++j)
    product_.col(j).noalias() = inverse_ * knot.C.col(columns[j]).segment(first, n_);
  for (int j = 0; j < count; ++j)
    for (int i = j; i < count; ++i)
      to(columns[i], columns[j]) += knot.C.col(columns[i]).segment(first, n_).dot(product_.col(j));
}

void InteriorCone::expand(const ShootingProblem& problem, const Linearization& linearization,
                          const LinearRollout& step, double left, StepLimits& limits) {
  const KnotLinearization& knot = linearization.knots[node()];
  const int first = constraint_->row - problem.constraint_offset(node());
  along_.setZero();
  for (const int column : constraint_->term->blocks.front().columns)
    along_ += step.z(node())[column] * knot.C.col(column).segment(first, n_);
  work_ = push_ - along_;
  dnu_.noalias() = inverse_ * work_;
  ds_ = along_ + residual_;
  dp_ = off_;
  dp_.noalias() += P_ * dnu_;
  ds_ += dp_;
  const double share = 1 - left;
  limits.primal = std::min(limits.primal, share * in_cone_until(s_, ds_));
  limits.dual = std::min(limits.dual, share * in_cone_until(nu_, dnu_));
  if (!is_soft()) return;
  const double w = constraint_->limit;
  limits.dual = std::min(limits.dual, share * positive_until(w * w - nu_.squaredNorm(),
                                                             -nu_.dot(dnu_), -dnu_.squaredNorm()));
}

/// ν of p = 2 μ ν / (w² − ‖ν‖²).
void InteriorCone::find_elastic_dual(double mu) const {
  const double w = constraint_->limit, size = p_.norm();
  // Without cancellation: (√(μ² + w² p²) − μ)/p = w² p / (√(μ² + w² p²) + μ).
  work_ = (w * w / (std::sqrt(mu * mu + w * w * size * size) + mu)) * p_;
}

double InteriorCone::barrier_slope(double mu) const {
  reflect(s_, work_);
  double slope = nu_.dot(along_) - mu / determinant(s_) * work_.dot(ds_);
  if (!is_soft()) return slope;
  find_elastic_dual(mu);
  return slope + work_.dot(dp_);
}

double InteriorCone::barrier_function(double mu) const {
  double value = -0.5 * mu * std::log(determinant(s_));
  if (!is_soft()) return value;
  find_elastic_dual(mu);
  const double w = constraint_->limit;
  return value + work_.dot(p_) + mu * std::log(w * w - work_.squaredNorm());
}

void InteriorCone::move(double length) {
  s_ = saved_s_ + length * ds_;
  p_ = saved_p_ + length * dp_;
}

double InteriorCone::infeasibility(const Vector& rows) const {
  return (values(rows) + p_ - s_).lpNorm<1>();
}

double InteriorCone::largest_residual() const {
  return std::max(residual_.lpNorm<Eigen::Infinity>(), off_.lpNorm<Eigen::Infinity>());
}

double InteriorCone::off_center(double mu) const {
  work_ = s_[n_ - 1] * nu_ + nu_[n_ - 1] * s_;
  work_[n_ - 1] = s_.dot(nu_) - mu;
  return work_.lpNorm<Eigen::Infinity>();
}

}  // namespace conddp
