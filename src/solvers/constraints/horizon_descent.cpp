#include "solvers/constraints/horizon_descent.hpp"

#include <cmath>

#include "ocp/terms/constraint.hpp"

namespace conddp {
namespace {

/// Weights as a multiple of the stages' curvature.
constexpr double kWeight = 10;

/// Share of the initial slope that a line search may leave, and its maximum number of
/// evaluations.
constexpr double kSlopeLeft = 1e-3;
constexpr int kEvaluations = 50;

struct SlopeAt {
  double step, slope;
};

/// Finds the step where an increasing slope, negative at `low` and positive at `high`, is at most
/// `allowed`. Uses regula falsi, which halves the value of an end that stays (Illinois).
template <class Slope>
double vanishing_slope(const Slope& slope_at, SlopeAt low, SlopeAt high, double allowed) {
  const SlopeAt* last_moved = nullptr;
  double step = high.step;
  for (int i = 0; i < kEvaluations; ++i) {
    step = (low.step * high.slope - high.step * low.slope) / (high.slope - low.slope);
    const double slope = slope_at(step);
    if (std::abs(slope) <= allowed) break;
    SlopeAt& moved = slope < 0 ? low : high;
    SlopeAt& stays = slope < 0 ? high : low;
    if (last_moved == &moved) stays.slope /= 2;
    moved = {step, slope};
    last_moved = &moved;
  }
  return step;
}

}  // namespace

PenalizedBounds::PenalizedBounds(const ControlBounds& bounds) : bounds_(bounds) {
  for (Eigen::VectorXd* v : {&weight_, &base_, &outside_})
    *v = Eigen::VectorXd::Zero(bounds.size());
}

void PenalizedBounds::start(const Trajectory& trajectory, const Eigen::VectorXd& gradient,
                            const BackwardSweep& sweep) {
  outside_.setZero();
  for (int k = 0; k < bounds_.knots(); ++k) {
    const auto u = trajectory.u(k);
    for (int i = 0; i < u.size(); ++i) {
      const int at = bounds_.offset(k) + i;
      const double slope = gradient[at];
      weight_[at] = kWeight * sweep.Quu(k)(i, i);
      base_[at] = u[i] - (bounds_.pushed_out(k, i, u[i], slope) ? slope / weight_[at] : 0);
    }
  }
}

int PenalizedBounds::revise(const std::vector<Eigen::VectorXd>& z, Linearization& linearization) {
  int changes = 0;
  for (int k = 0; k < bounds_.knots(); ++k) {
    KnotLinearization& knot = linearization.knots[k];
    for (int i = 0; i < knot.nu(); ++i) {
      const int at = bounds_.offset(k) + i;
      const double was = outside_[at];
      const double now =
          outside_bounds(base_[at] + z[k][knot.ndx + i], bounds_.lower(k)[i], bounds_.upper(k)[i]);
      changes += (was < 0) != (now < 0) || (was > 0) != (now > 0);
      set(k, i, now, knot);
    }
  }
  return changes;
}

void PenalizedBounds::remove(Linearization& linearization) {
  for (int k = 0; k < bounds_.knots(); ++k)
    for (int i = 0; i < linearization.knots[k].nu(); ++i) set(k, i, 0, linearization.knots[k]);
}

/// Beyond a bound, the derivative is w (s − bound) for any s there.
void PenalizedBounds::set(int k, int i, double outside, KnotLinearization& knot) {
  const int at = bounds_.offset(k) + i, column = knot.ndx + i;
  const double was = outside_[at], w = weight_[at];
  outside_[at] = outside;
  if ((was < 0) == (outside < 0) && (was > 0) == (outside > 0)) return;
  knot.gradient[column] += w * (model(k, i, base_[at], outside) - model(k, i, base_[at], was));
  knot.hessian.change()(column, column) += w * ((outside != 0) - (was != 0));
}

double PenalizedBounds::slope_beyond_model(const std::vector<Eigen::VectorXd>& z,
                                           const std::vector<Eigen::VectorXd>& to,
                                           double alpha) const {
  double sum = 0;
  for (int k = 0; k < bounds_.knots(); ++k) {
    const int nu = bounds_.offset(k + 1) - bounds_.offset(k);
    const int ndx = static_cast<int>(z[k].size()) - nu;
    for (int i = 0; i < nu; ++i) {
      const int at = bounds_.offset(k) + i;
      const double d = to[k][ndx + i] - z[k][ndx + i], s = base_[at] + z[k][ndx + i] + alpha * d;
      const double outside = outside_bounds(s, bounds_.lower(k)[i], bounds_.upper(k)[i]);
      sum += weight_[at] * (outside - model(k, i, s, outside_[at])) * d;
    }
  }
  return sum;
}

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

/// Finds the step where the derivative towards the minimum of the model vanishes; the derivative
/// increases with the step.
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
  const double at_start = derivative(0), at_end = derivative(1);
  if (!(at_start < 0)) return 0;
  if (at_end <= 1e-9 * -at_start) return 1;
  return vanishing_slope(derivative, {0, at_start}, {1, at_end}, kSlopeLeft * -at_start);
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
