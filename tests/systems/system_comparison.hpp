#pragma once

#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "support/random_numbers.hpp"
#include "systems/system.hpp"

namespace conddp {

// Two systems compared at random states and controls.

template <class S>
struct SystemPoint {
  AlignedVector<S> x, u;
};

/// A state and a control in every lane; dual numbers move along a random direction.
template <class S>
SystemPoint<S> random_point(const System& system, RandomNumbers& random) {
  const auto lane = [&](double value) {
    if constexpr (std::is_same_v<S, double>) {
      return value;
    } else {
      Lane a(value);
      for (int i = 1; i < kLaneWidth; ++i) a.set(i, value + random.uniform(-0.1, 0.1));
      if constexpr (std::is_same_v<S, Lane>)
        return a;
      else
        return S(a, Lane(random.uniform(-1, 1)));
    }
  };
  SystemPoint<S> point;
  AlignedVector<S> step;
  for (const double value : system.manifold().neutral()) point.x.push_back(S(value));
  for (int i = 0; i < system.ndx(); ++i) step.push_back(lane(random.uniform(-1, 1)));
  system.manifold().integrate(point.x.data(), step.data(), point.x.data());
  for (int i = 0; i < system.nu(); ++i) point.u.push_back(lane(random.uniform(-2, 2)));
  return point;
}

inline std::vector<double> lanes_of(double a) { return {a}; }
inline std::vector<double> lanes_of(Lane a) {
  std::vector<double> values;
  for (int i = 0; i < kLaneWidth; ++i) values.push_back(a[i]);
  return values;
}
inline std::vector<double> lanes_of(const Dual<Lane>& a) {
  std::vector<double> values = lanes_of(a.v);
  for (const double d : lanes_of(a.d)) values.push_back(d);
  return values;
}

template <class S>
void expect_equal_numbers(const AlignedVector<S>& got, const AlignedVector<S>& expected,
                          double tolerance, const std::string& what) {
  ASSERT_EQ(got.size(), expected.size()) << what;
  for (std::size_t i = 0; i < got.size(); ++i) {
    const std::vector<double> a = lanes_of(got[i]), b = lanes_of(expected[i]);
    for (std::size_t j = 0; j < a.size(); ++j)
      ASSERT_NEAR(a[j], b[j], tolerance * (1 + std::abs(b[j]))) << what << ' ' << i << ' ' << j;
  }
}

template <class S>
void expect_equal_answers(const std::string& name, const System& got, const System& expected,
                          double tolerance = 1e-12) {
  RandomNumbers random(311);
  const auto a = got.create_data(S{}), b = expected.create_data(S{});
  for (int repeat = 0; repeat < 20; ++repeat) {
    const SystemPoint<S> point = random_point<S>(expected, random);
    got.evaluate(point.x.data(), point.u.data(), *a);
    expected.evaluate(point.x.data(), point.u.data(), *b);
    expect_equal_numbers(a->f, b->f, tolerance, name + " f");
    const AlignedVector<S> alone = a->f;
    got.differentiate(point.x.data(), point.u.data(), *a);
    expected.differentiate(point.x.data(), point.u.data(), *b);
    expect_equal_numbers(a->f, alone, 0, name + " f with derivatives");
    expect_equal_numbers(a->fx, b->fx, tolerance, name + " fx");
    expect_equal_numbers(a->fu, b->fu, tolerance, name + " fu");
  }
}

/// Derivatives of the weighted answer's gradient along every direction, by dual numbers through a
/// system's Jacobians: column-major nz x nz.
inline AlignedVector<Lane> curvature_by_duals(const System& system, const SystemPoint<Lane>& point,
                                              const AlignedVector<Lane>& weights) {
  const int n = system.ndx(), nz = n + system.nu(), rows = system.rows();
  const auto data = system.create_data(Dual<Lane>{});
  AlignedVector<Lane> result(nz * nz, Lane(0.0));
  for (int d = 0; d < nz; ++d) {
    AlignedVector<Dual<Lane>> x, u, step(n, Dual<Lane>(0.0));
    for (const Lane& a : point.x) x.push_back({a, Lane(0.0)});
    for (const Lane& a : point.u) u.push_back({a, Lane(0.0)});
    (d < n ? step[d] : u[d - n]).d = Lane(1.0);
    system.manifold().integrate(x.data(), step.data(), x.data());
    system.differentiate(x.data(), u.data(), *data);
    for (int c = 0; c < nz; ++c)
      for (int i = 0; i < rows; ++i) {
        const auto& slope = c < n ? data->fx[c * rows + i] : data->fu[(c - n) * rows + i];
        result[d * nz + c] += weights[i] * slope.d;
      }
  }
  return result;
}

inline AlignedVector<Lane> symmetric_part(const AlignedVector<Lane>& a, int n) {
  AlignedVector<Lane> result(a.size());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) result[i * n + j] = Lane(0.5) * (a[i * n + j] + a[j * n + i]);
  return result;
}

/// A system's own second derivatives.
inline AlignedVector<Lane> own_curvature(const System& system, const SystemPoint<Lane>& point,
                                         const AlignedVector<Lane>& weights) {
  const auto at = system.create_data(Lane{});
  const auto moving = system.create_data(Dual<Lane>{});
  const auto second = system.second_derivatives(*at, *moving);
  EXPECT_EQ(second->forces(), 0);
  EXPECT_TRUE(second->at_once());
  const int nz = system.ndx() + system.nu();
  AlignedVector<Lane> result(nz * nz, Lane(0.0));
  AlignedVector<Dual<Lane>> x, u;
  for (const Lane& a : point.x) x.push_back({a, Lane(0.0)});
  for (const Lane& a : point.u) u.push_back({a, Lane(0.0)});
  system.differentiate(point.x.data(), point.u.data(), *at);
  second->start(x.data(), u.data());
  second->weigh(weights.data(), nullptr);
  second->finish(result.data());
  return result;
}

}  // namespace conddp
