#include "solvers/riccati/linear_rollout.hpp"

#include <array>

#include "ocp/evaluation/matrix_vector.hpp"
#include "spatial/lane_memory.hpp"

namespace conddp {
namespace {

/// Weights of the entries of the lower triangle in a quadratic form, starting kLaneWidth places
/// above the diagonal: 0 above it, 1 on it, 2 below it.
constexpr std::array<double, 2 * kLaneWidth> kCounts = [] {
  std::array<double, 2 * kLaneWidth> counts{};
  for (int i = kLaneWidth; i < 2 * kLaneWidth; ++i) counts[i] = i == kLaneWidth ? 1 : 2;
  return counts;
}();

/// zᵀ H z, summed over the entries that may be nonzero.
double quadratic_form(const KnotHessian& hessian, const Eigen::VectorXd& z) {
  const Eigen::MatrixXd& H = hessian();
  const int n = static_cast<int>(H.rows());
  Lane sum(0.0);
  const auto add = [&](int row, int column) {
    const int above = column - row;
    const Lane count = above < 0 ? Lane(2.0) : load_lane(kCounts.data() + kLaneWidth - above);
    const Lane h = load_some(H.col(column).data() + row, n - row);
    sum += h * (count * Lane(z[column]) * load_some(z.data() + row, n - row));
  };
  if (hessian.fill() == HessianFill::lasting) {
    for (const auto [row, column] : hessian.lasting_lanes()) add(row, column);
  } else {
    for (int column = 0; column < n; ++column)
      for (int row = column / kLaneWidth * kLaneWidth; row < n; row += kLaneWidth) add(row, column);
  }
  double total = 0;
  for (int l = 0; l < kLaneWidth; ++l) total += sum[l];
  return total;
}

}  // namespace

LinearRollout::LinearRollout(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds), ndx_(problem.ndx()), moved_(ndx_) {
  for (int k = 0; k <= problem.knots(); ++k)
    z_.push_back(Eigen::VectorXd::Zero(ndx_ + (k < problem.knots() ? problem.nu(k) : 0)));
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

void LinearRollout::apply(const StateManifold& manifold, double length,
                          Trajectory& trajectory) const {
  for (int k = 0; k <= bounds_.knots(); ++k) {
    moved_ = length * dx(k);
    double* x = trajectory.x(k).data();
    if (k > 0) manifold.integrate(x, moved_.data(), x);
    if (k < bounds_.knots()) trajectory.u(k) += length * du(k);
  }
}

double LinearRollout::curvature(const Linearization& linearization) const {
  double sum = 0;
  for (std::size_t k = 0; k < z_.size(); ++k)
    sum += quadratic_form(linearization.knots[k].hessian, z_[k]);
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
