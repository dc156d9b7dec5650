// Nearest faces of polytopes. A distance is proved by what any pair of convex bodies has: nearest
// points in both, and a plane between them; a depth by planes that separate no further.
#include "spatial/convex_distance.hpp"

#include <algorithm>
#include <fstream>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/random_numbers.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

using Vector = Vector3<double>;
using Points = std::vector<Vector>;

Vector unit(const Vector& v) { return (1 / std::sqrt(squared_norm(v))) * v; }

Points box(const Vector& half) {
  Points corners;
  for (const double x : {-half.x, half.x})
    for (const double y : {-half.y, half.y})
      for (const double z : {-half.z, half.z}) corners.push_back({x, y, z});
  return corners;
}

Points prism(double radius, double half_length, int faces) {
  Points corners;
  for (int i = 0; i < faces; ++i) {
    const double angle = 2 * std::numbers::pi * i / faces;
    for (const double z : {-half_length, half_length})
      corners.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
  }
  return corners;
}

/// A polytope of some kind: point, edge, box, prism, or the hull of random points.
Points random_polytope(RandomNumbers& random) {
  const auto size = [&] { return random.uniform(0.05, 0.5); };
  const auto points = [&](int count) {
    Points all;
    for (int i = 0; i < count; ++i) all.push_back(random.vector(0.4));
    return all;
  };
  switch (random.index(5)) {
    case 0:
      return points(1);
    case 1:
      return points(2);
    case 2:
      return box({size(), size(), size()});
    case 3:
      return prism(size(), size(), 32);
    default:
      return points(4 + random.index(30));
  }
}

/// Two polytopes in the axes of the first, and their distance.
struct Case {
  Points first, second;
  NearestPairs pairs;
  PolytopeDistance<double> distance;
  Vector gap;  ///< between the nearest points

  Case(const Points& one, const Points& other, const SE3<double>& placement,
       const DistanceRounding& rounding = {})
      : first(one) {
    for (const Vector& point : other) second.push_back(placement.R * point + placement.p);
    pairs = nearest_pairs(one, other, placement, rounding);
    PairCorners<double> corners;
    corners.count = pairs.count;
    corners.gap = pairs.gap;
    corners.overlap = pairs.overlap;
    corners.reversed = pairs.reversed;
    for (int i = 0; i < std::max(3, pairs.count); ++i) {
      corners.present[i] = i < pairs.count;
      corners.own[0][i] = one[pairs.first[i]];
      corners.own[1][i] = other[pairs.second[i]];
      corners.m[i] = first[pairs.first[i]] - second[pairs.second[i]];
    }
    distance = polytope_distance(corners, rounding);
    gap = distance.point[0] - (placement.R * distance.point[1] + placement.p);
  }

  /// Distance of the planes across `along` that touch the bodies, negative if they overlap.
  double separation(const Vector& along) const {
    const auto less = [&](const Vector& a, const Vector& b) {
      return dot(along, a) < dot(along, b);
    };
    return dot(along, *std::min_element(first.begin(), first.end(), less)) -
           dot(along, *std::max_element(second.begin(), second.end(), less));
  }
};

void expect_proved(const Case& c) {
  EXPECT_NEAR(squared_norm(c.distance.along), 1, 1e-12);
  EXPECT_NEAR(c.separation(c.distance.along), c.distance.distance, 1e-10);
  EXPECT_NEAR(dot(c.gap, c.distance.along), c.distance.distance, 1e-10);
  if (c.pairs.overlap) return;
  EXPECT_NEAR(std::sqrt(squared_norm(c.gap)), c.distance.distance, 1e-10);
}

TEST(NearestPairs, IsProvedByPlanes) {
  RandomNumbers random(3);
  int overlaps = 0;
  for (int i = 0; i < 4000; ++i) {
    const Points first = random_polytope(random), second = random_polytope(random);
    const SE3<double> placement = random.placement(0.8);
    if (first.size() + second.size() <= 4) continue;
    const Case c(first, second, placement);
    SCOPED_TRACE(i);
    expect_proved(c);
    overlaps += c.pairs.overlap;
    if (!c.pairs.overlap) continue;
    for (int k = 0; k < 100; ++k)
      EXPECT_LE(c.separation(unit(random.vector(1) + Vector{0, 0, 1e-6})),
                c.distance.distance + 1e-10);
  }
  EXPECT_GT(overlaps, 500);
}

/// Written by scripts/peers/distance_fixtures.py.
TEST(NearestPairs, DistancesAreThoseOfCoal) {
  std::ifstream file(source_tree() / "tests/spatial/data/distances.json");
  const auto pairs = nlohmann::json::parse(file).at("pairs");
  const auto vector = [](const nlohmann::json& p) { return Vector{p.at(0), p.at(1), p.at(2)}; };
  const auto points = [&](const nlohmann::json& list) {
    Points all;
    for (const auto& point : list) all.push_back(vector(point));
    return all;
  };
  EXPECT_GT(pairs.size(), 100u);
  for (const auto& pair : pairs) {
    SE3<double> placement{{}, vector(pair.at("p"))};
    for (int i = 0; i < 9; ++i) placement.R.m[i] = pair.at("R").at(i);
    const Case c(points(pair.at("first")), points(pair.at("second")), placement);
    const double radii =
        pair.at("first_radius").get<double>() + pair.at("second_radius").get<double>();
    EXPECT_NEAR(c.distance.distance - radii, pair.at("distance").get<double>(), 1e-9);
  }
}

TEST(NearestPairs, BoxesHaveTheDepthOfTheirAxes) {
  RandomNumbers random(5);
  for (int i = 0; i < 1000; ++i) {
    const auto size = [&] { return random.uniform(0.1, 0.5); };
    const SE3<double> placement = random.placement(0.15);
    const Case c(box({size(), size(), size()}), box({size(), size(), size()}), placement);
    ASSERT_TRUE(c.pairs.overlap);
    // The nearest face of a difference of boxes lies across an axis of one, or across two edges.
    double deepest = -10;
    const auto try_axis = [&](const Vector& axis) {
      if (squared_norm(axis) < 1e-12) return;
      deepest = std::max({deepest, c.separation(unit(axis)), c.separation(-unit(axis))});
    };
    for (int a = 0; a < 3; ++a) {
      const Vector own{a == 0 ? 1.0 : 0.0, a == 1 ? 1.0 : 0.0, a == 2 ? 1.0 : 0.0};
      try_axis(own);
      try_axis(placement.R.column(a));
      for (int b = 0; b < 3; ++b) try_axis(cross(own, placement.R.column(b)));
    }
    EXPECT_NEAR(c.distance.distance, deepest, 1e-10);
  }
}

TEST(NearestPairs, ParallelBodiesHaveTheirDistance) {
  const Points one = box({0.3, 0.2, 0.1});
  const Points round = prism(0.2, 0.3, 32);
  SE3<double> placement = SE3<double>::identity();
  for (const double z : {0.3, 0.2 + 1e-6, 0.2 - 1e-6, 0.2, 0.1, 1e-9}) {
    placement.p = {0.05, -0.02, z};
    EXPECT_NEAR(Case(one, one, placement).distance.distance, z - 0.2, 1e-9) << z;
    EXPECT_NEAR(Case(one, {{0, 0, 0}}, placement).distance.distance, z - 0.1, 1e-9) << z;
    placement.p = {0, 0, z + 0.2};
    EXPECT_NEAR(Case(one, round, placement).distance.distance, z - 0.2, 1e-9) << z;
    EXPECT_NEAR(Case(one, {{0, 0, 0}, {0.1, 0, 0}}, placement).distance.distance, z + 0.1, 1e-9);
  }
}

/// A rounded distance is the least one, and within its bounds.
TEST(NearestPairs, RoundedDistancesAreLeastAndBounded) {
  RandomNumbers random(7);
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(i);
    const Points one = random_polytope(random), other = random_polytope(random);
    const SE3<double> placement = random.placement(1);
    DistanceRounding rounding{.length = 1e-3, .radius = {0.8, 0.9}};
    rounding.center[0] = random.vector(0.05);
    const Case exact(one, other, placement), c(one, other, placement, rounding);
    EXPECT_LE(c.distance.distance, exact.distance.distance + 1e-10);
    EXPECT_GE(c.distance.distance, exact.distance.distance - 2 * rounding.length - 1e-10);
    if (c.pairs.overlap) continue;
    // The points are the best ones if the derivative leads away from all vertices.
    const Vector along = unit(c.gap);
    for (int body = 0; body < 2; ++body) {
      const double factor = 2 * rounding.length / (rounding.radius[body] * rounding.radius[body]);
      const Vector away = factor * (c.distance.point[body] - rounding.center[body]);
      const Vector slope = body == 0 ? away + along : away - transpose_times(placement.R, along);
      for (const Vector& vertex : body == 0 ? one : other)
        EXPECT_GE(dot(slope, vertex - c.distance.point[body]), -1e-8);
    }
  }
}

/// Turning one of two parallel boxes moves the nearest point of exact distances by the width of the
/// box, and of rounded ones in proportion to the angle.
TEST(NearestPairs, RoundedDistancesHaveContinuousDerivatives) {
  const Points hand = box({0.05, 0.05, 0.05}), board = box({0.4, 0.4, 0.01});
  const DistanceRounding rounding{.length = 5e-4, .radius = {0.09, 0.6}};
  const auto placed = [](double angle, double height) {
    const double c = std::cos(angle), s = std::sin(angle);
    return SE3<double>{{{c, 0, s, 0, 1, 0, -s, 0, c}}, {0, 0, -0.06 - height}};
  };
  const auto nearest_x = [&](double angle, const DistanceRounding& by) {
    return Case(hand, board, placed(angle, 0.01), by).distance.point[0].x;
  };
  EXPECT_GT(std::abs(nearest_x(1e-6, {}) - nearest_x(-1e-6, {})), 0.09);
  EXPECT_LT(std::abs(nearest_x(1e-6, rounding) - nearest_x(-1e-6, rounding)), 1e-4);
  EXPECT_NEAR(nearest_x(0, rounding), 0, 1e-9);
}

TEST(NearestPairs, IdenticalAndFlatBodiesHaveFiniteAnswers) {
  const SE3<double> same = SE3<double>::identity();
  const Points flat = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  const Case identical(box({0.3, 0.2, 0.1}), box({0.3, 0.2, 0.1}), same);
  EXPECT_NEAR(identical.distance.distance, -0.2, 1e-12);
  for (const Points& other : {Points{{0.4, 0.3, 0}}, Points{{0.4, 0.3, 0}, {0.5, 0.6, 0}}, flat}) {
    const Case c(flat, other, same);
    EXPECT_NEAR(c.distance.distance, 0, 1e-12);
    EXPECT_NEAR(squared_norm(c.distance.along), 1, 1e-12);
  }
}

/// All points lie in the hull of a few, but for the tolerance.
TEST(HullPoints, ReachAllPoints) {
  RandomNumbers random(11);
  for (const double tolerance : {0.0, 1e-3, 0.05}) {
    Points points;
    for (int i = 0; i < 300; ++i) points.push_back(random.vector(1));
    const Points hull = hull_points(points, tolerance);
    EXPECT_LT(hull.size(), 120u);
    for (const Vector& point : points)
      EXPECT_LE(Case({point}, hull, SE3<double>::identity()).distance.distance, tolerance + 1e-9);
  }
  EXPECT_EQ(hull_points(Points(5, Vector{1, 2, 3}), 0).size(), 1u);
  EXPECT_EQ(hull_points(Points{{0, 0, 0}, {0.5, 0, 0}, {1, 0, 0}}, 1e-6).size(), 2u);
}

}  // namespace
}  // namespace conddp
