#include "solvers/constraints/penalized_bounds.hpp"

#include "ocp/terms/constraint.hpp"

namespace conddp {
namespace {

/// Weights as a multiple of the stages' curvature.
constexpr double kWeight = 10;

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

}  // namespace conddp
