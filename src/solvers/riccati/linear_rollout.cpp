#include "solvers/riccati/linear_rollout.hpp"

#include <algorithm>

#include "ocp/evaluation/matrix_vector.hpp"

namespace conddp {

LinearRollout::LinearRollout(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds), ndx_(problem.ndx()) {
  int largest = ndx_;
  for (int k = 0; k <= problem.knots(); ++k) {
    const int nz = ndx_ + (k < problem.knots() ? problem.nu(k) : 0);
    z_.push_back(Eigen::VectorXd::Zero(nz));
    largest = std::max(largest, nz);
  }
  product_.resize(largest);
}

void LinearRollout::run(const Linearization& linearization, const Trajectory& trajectory,
                        const Gaps& gaps, const Feedback& feedback, bool clamp) {
  const int N = bounds_.knots();
  slope_ = 0;
  z_[0].head(ndx_).setZero();
  for (int k = 0; k < N; ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    const auto dx = z_[k].head(ndx_);
    auto du = z_[k].tail(knot.nu());
    du = feedback.k[k];
    multiply_add(feedback.K[k], dx.data(), du.data());
    if (clamp) {
      const auto u = trajectory.u(k);
      du = du.cwiseMin(bounds_.upper(k) - u).cwiseMax(bounds_.lower(k) - u);
    }
    slope_ += knot.gradient.dot(z_[k]);
    auto next = z_[k + 1].head(ndx_);
    knot.apply(z_[k], next);
    gaps[k].push(next);
  }
  slope_ += linearization.knots[N].gradient.dot(z_[N]);
}

void LinearRollout::measure_slope(const Linearization& linearization) {
  slope_ = 0;
  for (std::size_t k = 0; k < z_.size(); ++k) slope_ += linearization.knots[k].gradient.dot(z_[k]);
}

void LinearRollout::respond(const Linearization& linearization, const Gaps& gaps,
                            const Feedback& feedback) {
  z_[0].head(ndx_).setZero();
  for (int k = 0; k < bounds_.knots(); ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    multiply(feedback.K[k], z_[k].data(), z_[k].data() + ndx_);
    auto next = z_[k + 1].head(ndx_);
    knot.apply(z_[k], next);
    gaps[k].push(next);
  }
}

void LinearRollout::apply(const StateManifold& manifold, Trajectory& trajectory) const {
  for (int k = 0; k <= bounds_.knots(); ++k) {
    double* x = trajectory.x(k).data();
    if (k > 0) manifold.integrate(x, z_[k].data(), x);
    if (k < bounds_.knots()) trajectory.u(k) += du(k);
  }
}

double LinearRollout::curvature(const Linearization& linearization) {
  double sum = 0;
  for (std::size_t k = 0; k < z_.size(); ++k) {
    auto product = product_.head(z_[k].size());
    multiply(linearization.knots[k].hessian(), z_[k].data(), product.data());
    sum += z_[k].dot(product);
  }
  return sum;
}

int LinearRollout::revise(ActiveSet& active_set, std::optional<int>& last) const {
  int changes = 0;
  for (int k = 0; k < bounds_.knots(); ++k) {
    const int here = active_set.revise(k, dx(k), du(k));
    if (here > 0) last = k;
    changes += here;
  }
  return changes;
}

}  // namespace conddp
