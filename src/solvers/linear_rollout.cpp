#include "solvers/linear_rollout.hpp"

#include <algorithm>

namespace conddp {

LinearRollout::LinearRollout(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds), gap_(problem.manifold()), dx_(problem.ndx()), lambda_(problem.ndx()) {
  int largest = problem.ndx();
  for (int k = 0; k < problem.knots(); ++k) {
    largest = std::max(largest, problem.ndx() + problem.nu(k));
  }
  z_.resize(largest);
  product_.resize(largest);
}

ModelStep LinearRollout::run(const Linearization& linearization, const Trajectory& trajectory,
                             const Feedback& feedback, const BackwardSweep& sweep, bool open_gaps,
                             bool clamp) {
  const int N = bounds_.knots();
  const int ndx = static_cast<int>(dx_.size());
  ModelStep step;
  dx_.setZero();
  for (int k = 0; k <= N; ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    auto z = z_.head(ndx + knot.nu());
    auto product = product_.head(z.size());
    z.head(ndx) = dx_;
    if (k < N) {
      auto du = z.tail(knot.nu());
      du = feedback.k[k];
      du.noalias() += feedback.K[k] * dx_;
      if (clamp) {
        const auto u = trajectory.u(k);
        du = du.cwiseMin(bounds_.upper(k) - u).cwiseMax(bounds_.lower(k) - u);
      }
    }
    product.noalias() = knot.hessian * z;
    step.slope += knot.gradient.dot(z);
    step.curvature += z.dot(product);
    if (k == N) break;
    knot.apply(z, dx_);
    if (open_gaps) {
      gap_.set(linearization.gap.col(k));
      gap_.push(dx_);
    }
    const ValueFunction& next = sweep.value(k + 1);
    lambda_ = next.Vx;
    lambda_.noalias() += next.Vxx * dx_;
    step.multiplier = std::max(step.multiplier, lambda_.lpNorm<Eigen::Infinity>());
  }
  return step;
}

int LinearRollout::revise(const Linearization& linearization, const Feedback& feedback,
                          bool open_gaps, bool release, StagePolicy& policy) {
  const int ndx = static_cast<int>(dx_.size());
  int changes = 0;
  dx_.setZero();
  for (int k = 0; k < bounds_.knots(); ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    auto z = z_.head(ndx + knot.nu());
    z.head(ndx) = dx_;
    auto du = z.tail(knot.nu());
    du = feedback.k[k];
    du.noalias() += feedback.K[k] * dx_;
    changes += policy.revise(k, z.head(ndx), du, release);
    knot.apply(z, dx_);
    if (open_gaps) {
      gap_.set(linearization.gap.col(k));
      gap_.push(dx_);
    }
  }
  return changes;
}

}  // namespace conddp
