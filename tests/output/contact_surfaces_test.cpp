// Contact surfaces of problem-file obstacles at manually set poses.
#include "output/schedule/contact_surfaces.hpp"

#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// A point at the lower rear corner of a block, next to a box, a ball, and a soft wall.
constexpr const char* kScene = R"(conddp: 1
name: scene
robot: {urdf: robots/block.urdf, actuation: {joints: [base_x, base_z]}}
initial_state: {joints: {base_z: 0.6}}
contact_candidates:
  step: {frame: corner_1, against: {box: {size: [2, 1, 0.4], placement: {position: [2, 0, 0]}}}}
  ball: {frame: corner_1, against: {sphere: {radius: 1, center: [0, 0, -1]}}}
  soft: {frame: corner_1, stiffness: 100}
stepping: {plane: [0, 1, 0]}
phases: [{name: all, knots: 3, dt: 0.1}]
costs: {effort: {residual: control, weight: 1}}
solver: {name: ipopt}
)";

class Surfaces : public ::testing::Test {
 protected:
  Surfaces() {
    Diagnostics out;
    const auto file = source_tree() / "problems/scene.yaml";
    spec_ = read_problem_text(kScene, file, {}, out).value();
    built_ = build_problem(spec_, {}, out).value();
  }

  /// The level block with its corner at (x, z) at each of the four nodes.
  ContactMotion motion(const std::array<std::array<double, 2>, 4>& corner) const {
    Trajectory trajectory = built_.problem->create_trajectory();
    for (int k = 0; k < 4; ++k) {
      trajectory.x(k).setZero();
      trajectory.x(k)[0] = corner[k][0] + 0.5;
      trajectory.x(k)[1] = corner[k][1] + 0.5;
    }
    return *contact_motion(*built_.problem, trajectory);
  }
  static constexpr std::size_t kStep = 0, kBall = 1, kSoft = 2;

  ProblemSpec spec_;
  BuiltProblem built_;
};

TEST_F(Surfaces, FindsFaceWithLongestStayOutside) {
  // In front of the face at x = 1, above its edge, and over the top at z = 0.2.
  const ContactMotion over = motion({{{0.5, 0}, {0.9, 0.3}, {1.5, 0.4}, {2, 0.2}}});
  const ContactSurfaces surfaces(over);
  EXPECT_EQ(surfaces.count(kStep), 6);
  EXPECT_EQ(surfaces.count(kSoft), 0);
  EXPECT_EQ(surfaces.longest_outside(kStep, 0), 1) << "behind −x";
  EXPECT_EQ(surfaces.longest_outside(kStep, 1), 4) << "above +z";
  EXPECT_TRUE(surfaces.is_outside(kStep, 1, 1));
  EXPECT_FALSE(surfaces.is_outside(kStep, 1, 2));
  EXPECT_EQ(surfaces.touched(kStep, 3, 3), 4);
  EXPECT_EQ(surfaces.obstacle(kStep, 4, 0.01)["half_space"]["point"],
            (OrderedJson{2.0, 0.0, 0.19}));
}

TEST_F(Surfaces, CornerInsideABoxHasNoFace) {
  const ContactMotion inside = motion({{{2, 0}, {2, 0}, {2, 0.3}, {2, 0.3}}});
  const ContactSurfaces surfaces(inside);
  EXPECT_EQ(surfaces.longest_outside(kStep, 0), std::nullopt);
  EXPECT_EQ(surfaces.longest_outside(kStep, 2), 4);
}

TEST_F(Surfaces, RotatingNormalIsNoSurface) {
  const ContactMotion along = motion({{{0, 0}, {0, 0}, {0.6, -0.2}, {0.9, 0.3}}});
  const ContactSurfaces surfaces(along);
  EXPECT_EQ(surfaces.touched(kBall, 0, 1), 0);
  EXPECT_EQ(surfaces.touched(kBall, 0, 2), std::nullopt);
  EXPECT_NEAR(surfaces.normal(kBall, 2).x, 0.6, 1e-12);
  EXPECT_EQ(surfaces.touched(kStep, 3, 3), std::nullopt) << "nearest to an edge";
  EXPECT_EQ(surfaces.obstacle(kBall, 0, 0.01)["sphere"]["radius"], 0.99);
}

}  // namespace
}  // namespace conddp
