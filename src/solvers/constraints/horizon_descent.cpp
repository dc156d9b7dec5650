#include "solvers/constraints/horizon_descent.hpp"

#include <cmath>

namespace conddp {
namespace {

/// The share of the slope at the point that a line search may leave, and its evaluations at most.
constexpr double kSlopeLeft = 1e-3;
constexpr int kEvaluations = 50;

}  // namespace

HorizonDescent::HorizonDescent(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds), ndx_(problem.ndx()), penalties_(bounds) {
  Eigen::Index largest = 0;
  for (int k = 0; k <= problem.knots(); ++k) {
    const int nu = k < problem.knots() ? problem.nu(k) : 0;
    point_.push_back(Eigen::VectorXd::Zero(ndx_ + nu));
    largest = std::max(largest, point_.back().size());
  }
  d_.resize(largest);
  product_.resize(largest);
}

void HorizonDescent::start(const LinearRollout& step, const Trajectory& trajectory,
                           const Eigen::VectorXd& gradient, const BackwardSweep& sweep,
                           HorizonConstraints& constraints, Linearization& linearization) {
  for (std::size_t k = 0; k < point_.size(); ++k) point_[k] = step.z(static_cast<int>(k));
  constraints.keep(linearization);
  std::optional<int> last;
  constraints.revise(point_, 0, linearization, last);
  penalties_.start(trajectory, gradient, sweep);
  penalties_.revise(point_, linearization);
}

bool HorizonDescent::advance(const LinearRollout& minimum, HorizonConstraints& constraints,
                             Linearization& linearization) {
  const double step = step_length(minimum, constraints, linearization);
  for (std::size_t k = 0; k < point_.size(); ++k)
    point_[k] += step * (minimum.z(static_cast<int>(k)) - point_[k]);
  std::optional<int> last;
  const int changes =
      constraints.revise(point_, 0, linearization, last) + penalties_.revise(point_, linearization);
  return step == 0 || (step == 1 && changes == 0);
}

/// Where the derivative along the way to the minimum of the model vanishes: it grows with the
/// step.
double HorizonDescent::step_length(const LinearRollout& minimum, HorizonConstraints& constraints,
                                   const Linearization& linearization) {
  double slope = 0, curvature = 0;
  for (std::size_t k = 0; k < point_.size(); ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    auto d = d_.head(point_[k].size());
    auto product = product_.head(point_[k].size());
    d = minimum.z(static_cast<int>(k)) - point_[k];
    product.noalias() = knot.hessian() * d;
    slope += knot.gradient.dot(d) + point_[k].dot(product);
    curvature += d.dot(product);
  }
  constraints.set_path(point_, minimum.z(), linearization);
  const auto derivative = [&](double step) {
    return slope + step * curvature + constraints.slope_beyond_model(step) +
           penalties_.slope_beyond_model(point_, minimum.z(), step);
  };
  double low = 0, high = 1, at_low = derivative(0), at_high = derivative(1);
  if (!(at_low < 0)) return 0;
  const double allowed = kSlopeLeft * -at_low;
  if (at_high <= 1e-9 * -at_low) return 1;
  // Regula falsi, which halves the value of an end that stays (Illinois).
  int stayed = 0;
  double step = 1;
  for (int i = 0; i < kEvaluations; ++i) {
    step = (low * at_high - high * at_low) / (at_high - at_low);
    const double now = derivative(step);
    if (std::abs(now) <= allowed) break;
    if (now < 0) {
      low = step;
      at_low = now;
      if (stayed == -1) at_high /= 2;
      stayed = -1;
    } else {
      high = step;
      at_high = now;
      if (stayed == 1) at_low /= 2;
      stayed = 1;
    }
  }
  return step;
}

void HorizonDescent::leave(ActiveSet& active_set, Linearization& linearization) {
  for (int k = 0; k < bounds_.knots(); ++k) active_set.assume_sides(k, penalties_.outside(k));
  penalties_.remove(linearization);
}

void HorizonDescent::write(Feedback& feedback) const {
  for (int k = 0; k < bounds_.knots(); ++k) {
    feedback.k[k] = point_[k].tail(point_[k].size() - ndx_);
    feedback.k[k].noalias() -= feedback.K[k] * point_[k].head(ndx_);
  }
}

}  // namespace conddp
