#include "systems/state_manifold.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "spatial/dual.hpp"
#include "support/random_numbers.hpp"

namespace conddp {
namespace {

using Part = StateManifold::Part;
using D = Dual<double>;
using Numbers = std::vector<double>;

/// Every kind of part, some of them twice.
StateManifold mixed() {
  StateManifold m;
  m.append(Part::flat, 2);
  m.append(Part::se3);
  m.append(Part::so3);
  StateManifold rest = StateManifold::flat(3);
  rest.append(Part::se3);
  m.append(rest);
  return m;
}

Numbers random_point(const StateManifold& m, RandomNumbers& random) {
  Numbers x(m.nx());
  for (double& value : x) value = random.uniform(-2, 2);
  for (const StateManifold::Segment& s : m.curved()) {
    const Quaternion<double> q = random.rotation();
    const double values[] = {q.x, q.y, q.z, q.w};
    std::copy(std::begin(values), std::end(values), &x[s.x + (s.part == Part::se3 ? 3 : 0)]);
  }
  return x;
}

/// A tangent vector with rotations by `angle`.
Numbers random_step(const StateManifold& m, RandomNumbers& random, double angle) {
  Numbers dx(m.ndx());
  for (double& value : dx) value = random.uniform(-1, 1);
  for (const StateManifold::Segment& s : m.curved()) {
    double* w = &dx[s.dx + (s.part == Part::se3 ? 3 : 0)];
    const double norm = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    for (int i = 0; i < 3; ++i) w[i] *= angle / norm;
  }
  return dx;
}

Numbers plus(const StateManifold& m, const Numbers& x, const Numbers& dx) {
  Numbers out(m.nx());
  m.integrate(x.data(), dx.data(), out.data());
  return out;
}
Numbers minus(const StateManifold& m, const Numbers& x1, const Numbers& x0) {
  Numbers dx(m.ndx());
  m.difference(x0.data(), x1.data(), dx.data());
  return dx;
}

std::vector<D> constant(const Numbers& a) { return {a.begin(), a.end()}; }
std::vector<D> seeded(const Numbers& a, const Numbers& along) {
  std::vector<D> r;
  for (std::size_t i = 0; i < a.size(); ++i) r.emplace_back(a[i], along[i]);
  return r;
}
/// Slope of the tangent vector x1 ⊖ x0.
Numbers slope(const StateManifold& m, const std::vector<D>& x1, const std::vector<D>& x0) {
  std::vector<D> dx(m.ndx());
  m.difference(x0.data(), x1.data(), dx.data());
  Numbers r;
  for (const D& d : dx) r.push_back(d.d);
  return r;
}
std::vector<D> plus(const StateManifold& m, const std::vector<D>& x, const std::vector<D>& dx) {
  std::vector<D> out(m.nx());
  m.integrate(x.data(), dx.data(), out.data());
  return out;
}

/// Jacobian blocks (identity elsewhere) times a tangent vector.
Numbers apply(const StateManifold& m, const Numbers& blocks, const Numbers& dx) {
  Numbers out = dx;
  const double* block = blocks.data();
  for (const StateManifold::Segment& s : m.curved()) {
    for (int i = 0; i < s.n; ++i) {
      out[s.dx + i] = 0;
      for (int j = 0; j < s.n; ++j) out[s.dx + i] += block[i * s.n + j] * dx[s.dx + j];
    }
    block += StateManifold::kBlockSize;
  }
  return out;
}
Numbers blocks_for(const StateManifold& m) {
  return Numbers(m.curved().size() * StateManifold::kBlockSize,
                 std::numeric_limits<double>::quiet_NaN());
}

void expect_near(const Numbers& a, const Numbers& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "element " << i;
}

constexpr double kAngles[] = {1e-12,  1e-5, 1e-2, 0.4999, 0.5001,     0.9999,
                              1.0001, 2.0,  3.0,  3.14,   M_PI - 1e-7};

/// Calls test(x, dx, ξ) with small, generic, and almost half-turn steps.
template <class F>
void for_each_step(const StateManifold& m, F test) {
  RandomNumbers random(1);
  for (const double angle : kAngles) {
    SCOPED_TRACE(testing::Message() << "angle " << angle);
    for (int i = 0; i < 5; ++i) {
      const Numbers x = random_point(m, random);
      const Numbers dx = random_step(m, random, angle);
      test(x, dx, random_step(m, random, 1));
    }
  }
}

TEST(StateManifold, CountsItsParts) {
  const StateManifold m = mixed();
  EXPECT_EQ(m.nx(), 2 + 7 + 4 + 3 + 7);
  EXPECT_EQ(m.ndx(), 2 + 6 + 3 + 3 + 6);
  EXPECT_EQ(m.segments().size(), 5u);
  ASSERT_EQ(m.curved().size(), 3u);
  EXPECT_EQ(m.curved()[2].x, 16);
  EXPECT_EQ(m.curved()[2].dx, 14);
}

TEST(StateManifold, JoinsNeighbouringFlatParts) {
  StateManifold m = StateManifold::flat(2);
  m.append(Part::flat, 0);
  m.append(StateManifold::flat(3));
  ASSERT_EQ(m.segments().size(), 1u);
  EXPECT_EQ(m.segments()[0].n, 5);
  EXPECT_EQ(m.nx(), 5);
}

TEST(StateManifold, DifferenceUndoesIntegration) {
  const StateManifold m = mixed();
  for_each_step(m, [&](const Numbers& x, const Numbers& dx, const Numbers&) {
    expect_near(minus(m, plus(m, x, dx), x), dx, 1e-13);
  });
}

TEST(StateManifold, IntegrationUndoesDifference) {
  const StateManifold m = mixed();
  RandomNumbers random(2);
  for (int i = 0; i < 200; ++i) {
    const Numbers x0 = random_point(m, random), x1 = random_point(m, random);
    Numbers back = plus(m, x0, minus(m, x1, x0));
    for (const StateManifold::Segment& s : m.curved()) {
      const int q = s.x + (s.part == Part::se3 ? 3 : 0);
      if (back[q] * x1[q] < 0)
        for (int k = 0; k < 4; ++k) back[q + k] *= -1;  // the same rotation
    }
    expect_near(back, x1, 1e-13);
  }
}

TEST(StateManifold, IntegratesInPlace) {
  const StateManifold m = mixed();
  for_each_step(m, [&](const Numbers& x, const Numbers& dx, const Numbers&) {
    Numbers moved = x;
    m.integrate(moved.data(), dx.data(), moved.data());
    EXPECT_EQ(moved, plus(m, x, dx));
  });
}

TEST(StateManifold, IntegrationJacobiansMatchDualNumbers) {
  const StateManifold m = mixed();
  for_each_step(m, [&](const Numbers& x, const Numbers& dx, const Numbers& along) {
    Numbers wrt_x = blocks_for(m), wrt_dx = blocks_for(m);
    m.integrate_jacobians(dx.data(), wrt_x.data(), wrt_dx.data());
    const std::vector<D> to = constant(plus(m, x, dx));
    const Numbers zero(m.ndx(), 0.0);
    const std::vector<D> from = plus(m, constant(x), seeded(zero, along));
    expect_near(apply(m, wrt_x, along), slope(m, plus(m, from, constant(dx)), to), 1e-12);
    expect_near(apply(m, wrt_dx, along), slope(m, plus(m, constant(x), seeded(dx, along)), to),
                1e-12);
  });
}

TEST(StateManifold, DifferenceJacobiansMatchDualNumbers) {
  const StateManifold m = mixed();
  for_each_step(m, [&](const Numbers& x0, const Numbers& dx, const Numbers& along) {
    const Numbers x1 = plus(m, x0, dx);
    Numbers step = minus(m, x1, x0);
    const Numbers zero(m.ndx(), 0.0);
    Numbers blocks = blocks_for(m);
    m.inverse_right_jacobian(step.data(), blocks.data());
    expect_near(apply(m, blocks, along),
                slope(m, plus(m, constant(x1), seeded(zero, along)), constant(x0)), 1e-11);
    for (double& value : step) value = -value;
    m.inverse_right_jacobian(step.data(), blocks.data());
    Numbers wrt_x0 = apply(m, blocks, along);
    for (double& value : wrt_x0) value = -value;
    expect_near(wrt_x0, slope(m, constant(x1), plus(m, constant(x0), seeded(zero, along))), 1e-11);
  });
}

TEST(StateManifold, JacobiansEqualFiniteDifferences) {
  const StateManifold m = mixed();
  const double h = 1e-5;
  for_each_step(m, [&](const Numbers& x, const Numbers& dx, const Numbers& along) {
    Numbers wrt_x = blocks_for(m), wrt_dx = blocks_for(m);
    m.integrate_jacobians(dx.data(), wrt_x.data(), wrt_dx.data());
    const Numbers to = plus(m, x, dx);
    const auto moved = [&](const Numbers& start, double by) {
      Numbers r = start;
      for (int i = 0; i < m.ndx(); ++i) r[i] += by * along[i];
      return r;
    };
    const Numbers zero(m.ndx(), 0.0);
    Numbers slope_x = minus(m, plus(m, plus(m, x, moved(zero, h)), dx), to);
    Numbers slope_dx = minus(m, plus(m, x, moved(dx, h)), to);
    const Numbers back_x = minus(m, plus(m, plus(m, x, moved(zero, -h)), dx), to);
    const Numbers back_dx = minus(m, plus(m, x, moved(dx, -h)), to);
    for (int i = 0; i < m.ndx(); ++i) {
      slope_x[i] = (slope_x[i] - back_x[i]) / (2 * h);
      slope_dx[i] = (slope_dx[i] - back_dx[i]) / (2 * h);
    }
    expect_near(apply(m, wrt_x, along), slope_x, 1e-8);
    expect_near(apply(m, wrt_dx, along), slope_dx, 1e-8);
  });
}

TEST(StateManifold, LanesEqualDouble) {
  const StateManifold m = mixed();
  RandomNumbers random(3);
  std::vector<Lane> x(m.nx()), dx(m.ndx()), to(m.nx()), back(m.ndx());
  std::vector<Numbers> xs, steps;
  for (int lane = 0; lane < kLaneWidth; ++lane) {
    xs.push_back(random_point(m, random));
    steps.push_back(random_step(m, random, kAngles[lane]));
    for (int i = 0; i < m.nx(); ++i) x[i].set(lane, xs[lane][i]);
    for (int i = 0; i < m.ndx(); ++i) dx[i].set(lane, steps[lane][i]);
  }
  m.integrate(x.data(), dx.data(), to.data());
  m.difference(x.data(), to.data(), back.data());
  const std::size_t count = m.curved().size() * StateManifold::kBlockSize;
  std::vector<Lane> wrt_x(count, Lane(0.0)), wrt_dx(wrt_x), inverse(wrt_x);
  m.integrate_jacobians(dx.data(), wrt_x.data(), wrt_dx.data());
  m.inverse_right_jacobian(dx.data(), inverse.data());
  const auto lane_of = [](const std::vector<Lane>& values, int lane) {
    Numbers one;
    for (const Lane& value : values) one.push_back(value[lane]);
    return one;
  };
  for (int lane = 0; lane < kLaneWidth; ++lane) {
    const Numbers expected = plus(m, xs[lane], steps[lane]);
    expect_near(lane_of(to, lane), expected, 1e-14);
    expect_near(lane_of(back, lane), minus(m, expected, xs[lane]), 1e-13);
    Numbers one_x(count, 0.0), one_dx(count, 0.0), one_inverse(count, 0.0);
    m.integrate_jacobians(steps[lane].data(), one_x.data(), one_dx.data());
    m.inverse_right_jacobian(steps[lane].data(), one_inverse.data());
    expect_near(lane_of(wrt_x, lane), one_x, 1e-13);
    expect_near(lane_of(wrt_dx, lane), one_dx, 1e-13);
    expect_near(lane_of(inverse, lane), one_inverse, 1e-13);
  }
}

TEST(StateManifold, NeutralIsTheOriginWithUnitQuaternions) {
  const StateManifold m = mixed();
  Numbers expected(m.nx(), 0.0);
  expected[8] = expected[12] = expected[22] = 1;
  EXPECT_EQ(m.neutral(), expected);
}

TEST(StateManifold, NormalizeScalesNearlyUnitQuaternions) {
  const StateManifold m = mixed();
  Numbers x = m.neutral();
  x[8] = 1.0005;
  x[9] = 1e-4;
  EXPECT_TRUE(m.normalize(x.data()));
  EXPECT_NEAR(x[8], 1, 1e-15);
  EXPECT_NEAR(x[9] * x[9] + x[12] * x[12], 1, 1e-15);
}

TEST(StateManifold, NormalizeRejectsInvalidQuaternions) {
  const StateManifold m = mixed();
  for (const double bad : {0.0, 1.1, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    Numbers x = m.neutral();
    x[12] = bad;
    EXPECT_FALSE(m.normalize(x.data())) << bad;
  }
}

}  // namespace
}  // namespace conddp
