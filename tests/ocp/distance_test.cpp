// Shape distances, compared with searches that use no closed formulas. Derivatives are compared
// with dual numbers on robots of every kind, including non-unique closest points.
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "robot/kinematics.hpp"
#include "robot/urdf/urdf.hpp"
#include "spatial/closest_points.hpp"
#include "support/knot_case.hpp"
#include "support/mimic_robot.hpp"
#include "support/named_residuals.hpp"
#include "support/segments.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

using Eigen::Vector3d;

Vector3d put(const Vector3<double>& a) { return {a.x, a.y, a.z}; }

Segment<double> segment(const Vector3d& a, const Vector3d& b) {
  const Vector3d d = b - a;
  return {{a.x(), a.y(), a.z()}, {d.x(), d.y(), d.z()}, d.squaredNorm()};
}

/// Upper bound of a smoothed distance above the true one.
double excess(double distance, const Segment<double>& a, const Segment<double>& b) {
  const double ends = a.squared_length > 0 && b.squared_length > 0
                          ? kParallelSmoothing * (a.squared_length + b.squared_length) / 4
                          : 0;
  const double square = ends + kCrossingSmoothing * kCrossingSmoothing;
  return std::sqrt(distance * distance + square) - distance;
}

void expect_distance(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0,
                     const Vector3d& b1) {
  const Segment<double> first = segment(a0, a1), second = segment(b0, b1);
  const ClosestPoints<double> c = closest_points(first, second);
  const double expected = searched_distance(a0, a1, b0, b1);
  EXPECT_GE(c.distance, expected - 1e-9);
  EXPECT_LE(c.distance, expected + excess(expected, first, second) + 1e-12);
}

TEST(ClosestPoints, MatchASearch) {
  RandomNumbers random(3);
  const auto point = [&] {
    return Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  };
  for (int i = 0; i < 2000; ++i) {
    const Vector3d a0 = point(), b0 = point();
    const Vector3d a1 = i % 3 == 0 ? a0 : point(), b1 = i % 5 == 0 ? b0 : point();
    expect_distance(a0, a1, b0, b1);
  }
}

TEST(ClosestPoints, ParallelAndCrossingSegmentsHaveCorrectDistance) {
  const Vector3d x(1, 0, 0), y(0, 1, 0), o(0, 0, 0);
  for (const double angle : {0.0, 1e-12, 1e-8, 1e-4, 1e-2}) {
    const Vector3d along = std::cos(angle) * x + std::sin(angle) * y;
    expect_distance(o, x, 0.2 * y, 0.2 * y + along);                // side by side
    expect_distance(o, x, 0.2 * y + 0.7 * x, 0.2 * y + 2 * along);  // partly overlapping
    expect_distance(o, x, 1.5 * x, 1.5 * x + along);                // one after the other
    expect_distance(o, x, 0.2 * y + along, 0.2 * y);                // reversed
    expect_distance(-along, along, -y, y);                          // crossing
  }
}

/// Values of a residual in lanes with different states, compared with doubles.
TEST(DistanceResidual, IsTheSameInLanes) {
  RandomNumbers random(5);
  const auto robot =
      std::make_shared<RobotModel>(random_robot(12, {.joints = 7, .floating = true}));
  const MultibodySystem system(robot, Actuation::full(*robot));
  const auto shared = std::make_shared<MultibodySystem>(system);
  const auto residual = distance_residual(shared, distance_pairs(*robot));
  const int rows = residual->size(), entries = residual->jacobian_size();
  AlignedVector<Lane> x(system.nx()), r(rows), jacobian(entries);
  std::vector<std::vector<double>> states;
  for (int l = 0; l < kLaneWidth; ++l) {
    states.push_back(random_manifold_state(system.manifold(), random, 1.2));
    for (int i = 0; i < system.nx(); ++i) x[i].set(l, states[l][i]);
  }
  const auto lanes = system.create_data(Lane{});
  system.update_kinematics(x.data(), *lanes);
  residual->differentiate({x.data(), nullptr, nullptr, *lanes}, r.data(), jacobian.data());
  const auto one = system.create_data(double{});
  std::vector<double> value(rows), slopes(entries);
  for (int l = 0; l < kLaneWidth; ++l) {
    system.update_kinematics(states[l].data(), *one);
    residual->differentiate({states[l].data(), nullptr, nullptr, *one}, value.data(),
                            slopes.data());
    for (int i = 0; i < rows; ++i) EXPECT_NEAR(r[i][l], value[i], 1e-13);
    for (int i = 0; i < entries; ++i) EXPECT_NEAR(jacobian[i][l], slopes[i], 1e-9);
  }
}

/// Ends of a shape in the world.
std::pair<Vector3d, Vector3d> ends(const RobotModel& robot, const RobotData<double>& data,
                                   const Capsule& c) {
  SE3<double> m = SE3<double>::identity();
  if (c.frame >= 0) m = frame_placement(robot, data, c.frame);
  return {put(m.R * c.from + m.p), put(m.R * c.to + m.p)};
}

template <class Shape>
bool is_polytope(const Shape& shape) {
  return std::holds_alternative<Polytope>(shape);
}

TEST(DistanceResidual, IsDistanceBetweenSurfacesInTheWorld) {
  RandomNumbers random(7);
  for (const bool floating : {false, true}) {
    const auto robot =
        std::make_shared<RobotModel>(random_robot(21, {.joints = 8, .floating = floating}));
    const auto system = std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
    const std::vector<DistancePair> pairs = distance_pairs(*robot);
    const auto residual = distance_residual(system, pairs);
    const auto data = system->create_data(double{});
    std::vector<double> r(residual->size());
    for (int trial = 0; trial < 5; ++trial) {
      const auto x = random_manifold_state(system->manifold(), random, 1.2);
      system->update_kinematics(x.data(), *data);
      residual->evaluate({x.data(), nullptr, nullptr, *data}, r.data());
      RobotData<double> own(*robot);
      update_placements(*robot, x.data(), own);
      int row = 0;
      for (const DistancePair& pair : pairs) {
        if (is_polytope(pair.first) || is_polytope(pair.second)) {
          row += pair.rows();  // tests/spatial/convex_distance_test.cpp, and below
          continue;
        }
        const Capsule& capsule = std::get<Capsule>(pair.first);
        const auto [a0, a1] = ends(*robot, own, capsule);
        if (const auto* solid = std::get_if<HalfSpace>(&pair.second)) {
          const double level = solid->offset + capsule.radius;
          EXPECT_NEAR(r[row++], put(solid->normal).dot(a0) - level, 1e-12);
          if (pair.rows() == 2) {
            EXPECT_NEAR(r[row++], put(solid->normal).dot(a1) - level, 1e-12);
          }
          continue;
        }
        const Capsule& second = std::get<Capsule>(pair.second);
        const auto [b0, b1] = ends(*robot, own, second);
        const double axes = searched_distance(a0, a1, b0, b1);
        const double expected = axes - capsule.radius - second.radius;
        EXPECT_GE(r[row], expected - 1e-9);
        EXPECT_LE(r[row++], expected + excess(axes, segment(a0, a1), segment(b0, b1)) + 1e-12);
      }
      EXPECT_EQ(row, residual->size());
    }
  }
}

TEST(DistanceResidual, HasOnlyColumnsBetweenTheBodies) {
  const RobotModel robot = random_robot(31, {.joints = 9, .floating = true, .branching = 0.6});
  const auto system = std::make_shared<MultibodySystem>(std::make_shared<RobotModel>(robot),
                                                        Actuation::full(robot));
  for (int a = 0; a < static_cast<int>(robot.frames.size()); ++a)
    for (int b = 0; b < static_cast<int>(robot.frames.size()); ++b) {
      if (a == b) continue;
      const DistancePair pair{Capsule{a, {}, {0.1, 0, 0}, 0.1}, Capsule{b, {}, {}, 0.1}};
      const std::vector<int> first = support(robot, robot.frames[a].joint),
                             second = support(robot, robot.frames[b].joint);
      std::vector<int> expected;
      std::set_symmetric_difference(first.begin(), first.end(), second.begin(), second.end(),
                                    std::back_inserter(expected));
      EXPECT_EQ(distance_residual(system, {pair})->blocks()[0].columns, expected);
    }
}

/// All derivatives of a residual, compared with dual numbers relative to the largest one.
void expect_derivatives(const std::shared_ptr<const MultibodySystem>& system,
                        const std::vector<DistancePair>& pairs, const std::vector<double>& x) {
  using D = Dual<Lane>;
  const auto residual = distance_residual(system, pairs);
  const auto data = system->create_data(double{});
  const auto dual = system->create_data(D{});
  const int n = system->ndx();
  std::vector<double> r(residual->size()), packed(residual->jacobian_size());
  system->update_kinematics(x.data(), *data);
  residual->differentiate({x.data(), nullptr, nullptr, *data}, r.data(), packed.data());
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(residual->size(), n);
  const double* entry = packed.data();
  int row = 0;
  for (const RowBlock& block : residual->blocks()) {
    for (const int column : block.columns)
      for (int i = 0; i < block.rows; ++i) jacobian(row + i, column) = *entry++;
    row += block.rows;
  }
  const double scale = 1 + jacobian.lpNorm<Eigen::Infinity>();
  AlignedVector<D> rd(residual->size());
  for (int direction = 0; direction < n; ++direction) {
    AlignedVector<D> xd(x.begin(), x.end()), step(n, D(0.0));
    step[direction].d = Lane(1.0);
    system->manifold().integrate(xd.data(), step.data(), xd.data());
    system->update_kinematics(xd.data(), *dual);
    residual->evaluate({xd.data(), nullptr, nullptr, *dual}, rd.data());
    for (int i = 0; i < residual->size(); ++i) {
      ASSERT_TRUE(std::isfinite(jacobian(i, direction)));
      EXPECT_NEAR(jacobian(i, direction), rd[i].d[0], 1e-9 * scale) << i << ' ' << direction;
    }
  }
}

TEST(DistanceResidual, DerivativesMatchDualNumbers) {
  RandomNumbers random(11);
  std::vector<TestModel> robots = random_robots();
  for (TestModel& robot : mimic_robots()) robots.push_back(std::move(robot));
  for (const TestModel& robot : robots) {
    SCOPED_TRACE(robot.name);
    const auto system = std::make_shared<MultibodySystem>(std::make_shared<RobotModel>(robot.model),
                                                          Actuation::full(robot.model));
    for (int trial = 0; trial < 2; ++trial)
      expect_derivatives(system, distance_pairs(robot.model, 2),
                         random_manifold_state(system->manifold(), random, 1.2));
  }
}

/// A capsule is the hull of its ends, expanded by its radius.
TEST(DistanceResidual, HullsOfTheEndsAreCapsules) {
  RandomNumbers random(9);
  const auto robot =
      std::make_shared<RobotModel>(random_robot(17, {.joints = 8, .floating = true}));
  const auto system = std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
  const auto hull = [](const Capsule& c) { return Polytope{c.frame, {c.from, c.to}, c.radius}; };
  std::vector<DistancePair> capsules, hulls;
  for (const DistancePair& pair : distance_pairs(*robot)) {
    const auto *first = std::get_if<Capsule>(&pair.first),
               *second = std::get_if<Capsule>(&pair.second);
    if (first == nullptr || second == nullptr) continue;
    capsules.push_back(pair);
    hulls.push_back({hull(*first), hull(*second)});
  }
  const auto one = distance_residual(system, capsules), other = distance_residual(system, hulls);
  const auto data = system->create_data(double{});
  std::vector<double> r(one->size()), of_hulls(other->size());
  ASSERT_EQ(r.size(), of_hulls.size());
  for (int trial = 0; trial < 20; ++trial) {
    const auto x = random_manifold_state(system->manifold(), random, 1.2);
    system->update_kinematics(x.data(), *data);
    one->evaluate({x.data(), nullptr, nullptr, *data}, r.data());
    other->evaluate({x.data(), nullptr, nullptr, *data}, of_hulls.data());
    for (std::size_t i = 0; i < r.size(); ++i) EXPECT_NEAR(r[i], of_hulls[i], 2e-3);
  }
}

/// A distance that is to stay above a margin is less than it is, near by a hundredth of the smaller
/// body's radius at most.
TEST(DistanceResidual, DistancesAboveAMarginAreLowerBounds) {
  RandomNumbers random(15);
  const auto robot =
      std::make_shared<RobotModel>(random_robot(23, {.joints = 6, .floating = true}));
  const auto system = std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
  const double margin = 0.05, ball = 0.1;
  const Polytope rod{4, {{0, 0, -0.1}, {0, 0, 0.1}}, 0.05};
  const Polytope plate{-1, {{0.3, -1, 0}, {0.3, 1, 0}, {0.3, -1, 1}, {0.3, 1, 1}}, 0};
  const auto residual = distance_residual(system, {{rod, plate}, {rod, plate, margin}});
  const auto data = system->create_data(double{});
  int near = 0, bounds = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const auto x = random_manifold_state(system->manifold(), random, 1.2);
    double r[2];
    system->update_kinematics(x.data(), *data);
    residual->evaluate({x.data(), nullptr, nullptr, *data}, r);
    EXPECT_GE(r[1], r[0] - 2 * ball - 0.01 * ball);
    if (r[1] >= margin) {
      EXPECT_GE(r[0], margin - 1e-12);
      EXPECT_LE(r[1], r[0] + 1e-12);
    }
    if (r[0] < margin + ball + 0.05) {
      EXPECT_GE(r[1], r[0] - 0.01 * ball - 1e-12);
      ++near;
    }
    bounds += r[1] < r[0] - 1e-6;
    expect_derivatives(system, {{rod, plate, margin}}, x);
  }
  EXPECT_GT(near, 20);
  EXPECT_GT(bounds, 100);
}

/// A prism with many vertices has one height, that of its lowest vertex.
TEST(DistanceResidual, TheLowestOfManyVerticesCounts) {
  RandomNumbers random(13);
  const auto robot =
      std::make_shared<RobotModel>(random_robot(19, {.joints = 6, .floating = true}));
  const auto system = std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
  const HalfSpace ground{{0.36, -0.48, 0.8}, 0.1};
  Polytope many{2, {}, 0.03};
  std::vector<DistancePair> pairs;
  for (int i = 0; i < 12; ++i) {
    many.vertices.push_back(random.vector(1));
    pairs.push_back({Polytope{2, {many.vertices.back()}, 0.03}, ground});
  }
  pairs.push_back({many, ground});
  const auto residual = distance_residual(system, pairs);
  const auto data = system->create_data(double{});
  std::vector<double> r(residual->size());
  for (int trial = 0; trial < 10; ++trial) {
    const auto x = random_manifold_state(system->manifold(), random, 1.2);
    system->update_kinematics(x.data(), *data);
    residual->evaluate({x.data(), nullptr, nullptr, *data}, r.data());
    EXPECT_NEAR(r.back(), *std::min_element(r.begin(), r.end() - 1), 1e-12);
    expect_derivatives(system, {pairs.back()}, x);
  }
}

TEST(DistanceResidual, HasDerivativesForParallelAndCrossingCapsules) {
  // An arm stretched along z: capsules along its links are collinear, and a fixed one beside it is
  // parallel.
  const UrdfResult loaded = load_urdf(source_tree() / "problems/robots/arm7.urdf", {});
  ASSERT_TRUE(loaded.model);
  const auto robot = std::make_shared<RobotModel>(*loaded.model);
  const auto system = std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
  const int upper = *robot->find_frame("link_3"), lower = *robot->find_frame("link_5");
  const Capsule first{upper, {}, {0, 0, 0.2}, 0.05}, second{lower, {}, {0, 0, 0.2}, 0.05};
  const Capsule beside{-1, {0.3, 0, 0.6}, {0.3, 0, 1.2}, 0.05};
  const Capsule across{-1, {-1, 0, 0.9}, {1, 0, 0.9}, 0.02};
  const std::vector<double> stretched(system->nx(), 0.0);
  for (const DistancePair& pair :
       {DistancePair{first, second}, DistancePair{first, beside}, DistancePair{second, beside},
        DistancePair{first, across}, DistancePair{first, HalfSpace{{1, 0, 0}, -0.3}}})
    expect_derivatives(system, {pair}, stretched);
  std::vector<double> x = stretched;
  x[1] = 1e-9;  // lower links nearly parallel to the capsule beside them
  expect_derivatives(system, {{first, beside}, {second, beside}}, x);
}

}  // namespace
}  // namespace conddp
