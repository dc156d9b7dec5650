#include "analysis/contact/contact_sweeps.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {
namespace {

constexpr int kSweeps = 20000;
/// Impulses have converged if they change by less, relative to their scale.
constexpr double kFound = 1e-15;

/// Entries of p or u at the friction rows, as a pair.
Eigen::Vector2d pair_of(const Eigen::VectorXd& rows, const ImpulseBound& bound) {
  return {rows[bound.tangent], bound.tangents == 2 ? rows[bound.tangent + 1] : 0};
}

double radius_of(const Eigen::VectorXd& p, const ImpulseBound& bound) {
  return bound.normal < 0 ? bound.constant : bound.friction * p[bound.normal];
}

}  // namespace

Eigen::Vector2d nearest_friction(const Eigen::Vector2d& f, double radius, bool pyramid) {
  radius = std::max(0.0, radius);
  if (!pyramid) return f.norm() <= radius ? f : Eigen::Vector2d(f * (radius / f.norm()));
  if (f.cwiseAbs().sum() <= radius) return f;
  // Soft thresholding: both entries shrink by the same amount, none below zero.
  const Eigen::Vector2d size = f.cwiseAbs();
  double shrink = (size.sum() - radius) / 2;
  if (shrink > size.minCoeff()) shrink = size.maxCoeff() - radius;
  const Eigen::Vector2d left = (size.array() - shrink).cwiseMax(0);
  return {std::copysign(left.x(), f.x()), std::copysign(left.y(), f.y())};
}

double sweep_impulses(const Eigen::MatrixXd& D, const Eigen::VectorXd& u0,
                      const std::vector<ImpulseBound>& bounds, double scale, Eigen::VectorXd& p) {
  Eigen::VectorXd u = u0 + D * p;
  double change = 0;
  const auto set = [&](int row, double value) {
    const double off = value - p[row];
    if (off == 0) return;
    u += off * D.col(row);
    p[row] = value;
    change = std::max(change, std::abs(off) / scale);
  };
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    change = 0;
    for (const ImpulseBound& bound : bounds) {
      if (const int n = bound.normal; n >= 0 && D(n, n) > 0)
        set(n, std::max(0.0, p[n] - u[n] / D(n, n)));
      if (bound.tangents == 0) continue;
      const int t = bound.tangent;
      const double mobility = D.diagonal().segment(t, bound.tangents).sum();
      if (!(mobility > 0)) continue;
      const Eigen::Vector2d wanted = nearest_friction(
          pair_of(p, bound) - pair_of(u, bound) / mobility, radius_of(p, bound), bound.pyramid);
      for (int i = 0; i < bound.tangents; ++i) set(t + i, wanted[i]);
    }
    if (!(change > kFound)) break;
  }
  return change;
}

double impulse_residual(const Eigen::VectorXd& u, const std::vector<ImpulseBound>& bounds,
                        double scale, const Eigen::VectorXd& p) {
  double worst = 0;
  for (const ImpulseBound& bound : bounds) {
    if (const int n = bound.normal; n >= 0)
      worst = std::max(worst, std::abs(std::min(p[n] / scale, u[n])));
    if (bound.tangents == 0) continue;
    const Eigen::Vector2d f = pair_of(p, bound) / scale;
    const Eigen::Vector2d nearest =
        nearest_friction(f - pair_of(u, bound), radius_of(p, bound) / scale, bound.pyramid);
    worst = std::max(worst, (f - nearest).lpNorm<Eigen::Infinity>());
  }
  return worst;
}

}  // namespace conddp
