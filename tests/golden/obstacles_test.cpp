// Shapes of a motion around obstacles stay apart, measured by a search independent of the solvers.
#include <set>

#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/plant/shape_pairs.hpp"
#include "problem_file/read/read_problem.hpp"
#include "robot/frames.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/segments.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

using Eigen::Vector3d;

Vector3d put(const Vector3<double>& a) { return {a.x, a.y, a.z}; }

double distance_of(const DistancePair& pair, const Plant& plant, const std::vector<double>& x) {
  const auto ends = [&](const Capsule& c) {
    SE3<double> m = SE3<double>::identity();
    if (c.frame >= 0) m = placement_in_state(*plant.multibody(), x, c.frame);
    return std::pair(put(m.R * c.from + m.p), put(m.R * c.to + m.p));
  };
  const auto [a0, a1] = ends(std::get<Capsule>(pair.first));
  if (const auto* solid = std::get_if<HalfSpace>(&pair.second))
    return std::min(put(solid->normal).dot(a0), put(solid->normal).dot(a1)) - solid->offset -
           std::get<Capsule>(pair.first).radius;
  const Capsule& second = std::get<Capsule>(pair.second);
  const auto [b0, b1] = ends(second);
  return searched_distance(a0, a1, b0, b1) - std::get<Capsule>(pair.first).radius - second.radius;
}

TEST(ArmObstacles, KeepsDistanceFromBallPoleAndItself) {
  Diagnostics diagnostics;
  const auto spec = read_problem(source_tree() / "problems/arm_obstacles.yaml", {}, diagnostics);
  ASSERT_TRUE(spec);
  const auto built = build_problem(*spec, {}, diagnostics);
  ASSERT_TRUE(built);
  const SolveResult result =
      solve(*built->problem, spec->solver.name.value, spec->solver.options, built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const CostSpec& cost = spec->costs[0];
  const double margin = cost.keys.value(key::margin);
  std::set<std::string> touched;  // pairs at minimum distance
  for (const ShapePair& pair : shape_pairs(cost, *spec, built->plant, diagnostics)) {
    double smallest = kUnlimited;
    for (int k = 0; k <= built->problem->knots(); ++k) {
      const auto x = result.trajectory.x(k);
      const double d = distance_of(pair.shapes, built->plant, {x.begin(), x.end()});
      smallest = std::min(smallest, d);
    }
    // The barrier is soft and yields by a tenth of a millimeter.
    const std::string name = pair.first + "-" + pair.second;
    EXPECT_GE(smallest, margin - 2e-4) << name;
    if (smallest < margin + 1e-4) touched.insert(name);
  }
  EXPECT_EQ(touched, (std::set<std::string>{"forearm-hand", "hand-ball", "hand-pole"}));
}

}  // namespace
}  // namespace conddp
