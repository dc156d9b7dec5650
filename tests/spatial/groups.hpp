#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "spatial/dual.hpp"
#include "spatial/se3.hpp"
#include "support/random_numbers.hpp"

namespace conddp {

/// Angles where formulas change or cancel: 0, series thresholds (sin² θ/2 = 1e-4, θ = ½, θ = 1),
/// generic values, and around π.
inline std::vector<double> telling_angles() {
  std::vector<double> angles = {0, 1e-200, 1e-16, 1e-9, 1e-5, 1e-3, 0.1, 0.7, 1.5, 2.5};
  for (const double around : {0.02, 0.5, 1.0, M_PI})
    for (const double off : {-1e-3, -1e-8, -1e-13, 0.0}) angles.push_back(around + off);
  return angles;
}

/// Several directions, including the axes and their opposites.
inline std::vector<Vector3<double>> directions() {
  std::vector<Vector3<double>> all = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},
                                      {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  RandomNumbers random(1);
  for (int i = 0; i < 6; ++i) {
    const Vector3<double> v = random.vector(1);
    all.push_back((1 / std::sqrt(squared_norm(v))) * v);
  }
  return all;
}

inline double norm(const Vector3<double>& a) { return std::sqrt(squared_norm(a)); }
inline double largest(const Matrix3<double>& a) {
  double most = 0;
  for (const double x : a.m) most = std::max(most, std::abs(x));
  return most;
}
inline double largest(const Motion<double>& a) { return std::max(norm(a.linear), norm(a.angular)); }
inline double largest(const Force<double>& a) { return std::max(norm(a.linear), norm(a.angular)); }

inline Motion<double> operator*(const Matrix6<double>& a, const Motion<double>& m) {
  Motion<double> r = Motion<double>::zero();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) r[i] += a(i, j) * m[j];
  return r;
}

/// m + ε · along.
inline Motion<Dual<double>> seeded(const Motion<double>& m, const Motion<double>& along) {
  Motion<Dual<double>> r;
  for (int i = 0; i < 6; ++i) r[i] = {m[i], along[i]};
  return r;
}
inline Vector3<Dual<double>> seeded(const Vector3<double>& a, const Vector3<double>& along) {
  return {{a.x, along.x}, {a.y, along.y}, {a.z, along.z}};
}
inline Vector3<double> slope(const Vector3<Dual<double>>& a) { return {a.x.d, a.y.d, a.z.d}; }
inline Motion<double> slope(const Motion<Dual<double>>& m) {
  return {slope(m.linear), slope(m.angular)};
}
inline Quaternion<Dual<double>> constant(const Quaternion<double>& q) {
  return {q.x, q.y, q.z, q.w};
}
inline Pose<Dual<double>> constant(const Pose<double>& a) {
  return {a.p.cast<Dual<double>>(), constant(a.q)};
}

}  // namespace conddp
