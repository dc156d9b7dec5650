#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace conddp {

inline double point_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b) {
  const Eigen::Vector3d d = b - a;
  const double length = d.squaredNorm();
  const double t = length > 0 ? std::clamp((p - a).dot(d) / length, 0.0, 1.0) : 0;
  return (a + t * d - p).norm();
}

/// Distance of two segments by ternary search along the first; the distance to the second is convex
/// there.
inline double searched_distance(const Eigen::Vector3d& a0, const Eigen::Vector3d& a1,
                                const Eigen::Vector3d& b0, const Eigen::Vector3d& b1) {
  double low = 0, high = 1;
  const auto at = [&](double s) { return point_to_segment(a0 + s * (a1 - a0), b0, b1); };
  for (int i = 0; i < 200; ++i) {
    const double s = low + (high - low) / 3, t = high - (high - low) / 3;
    if (at(s) < at(t))
      high = t;
    else
      low = s;
  }
  return at(0.5 * (low + high));
}

}  // namespace conddp
