// Contact-implicit friction, compared with Coulomb's law in space.
#include <cmath>
#include <numbers>

#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

using testing::ReadyProblem;

constexpr double kSpeed = 1, kFriction = 0.3, kGravity = 9.81;  // m/s, -, m/s²

/// A passive puck sliding from an initial velocity.
ReadyProblem sliding_puck(double heading, const std::string& friction) {
  const auto component = [&](double share) { return fmt::format("{:.17g}", kSpeed * share); };
  return ReadyProblem(
      "puck_slide",
      {"stepping.friction=" + friction, "phases=[{name: slide, knots: 25, dt: 0.02}]",
       "constraints={alone: {bounds: control, lower: 0, upper: 0}}",
       // The equations determine the motion without any freedom, so the gradient does not matter.
       "solver.tolerances.stationarity=1.0e-5",
       "terminal={costs: {calm: {residual: joint_velocity, joints: [base_x], weight: 1.0e-3}}}",
       fmt::format("initial_state={{joints: {{base_z: 0.02}}, velocity: {{joints: {{base_x: {}, "
                   "base_y: {}}}}}}}",
                   component(std::cos(heading)), component(std::sin(heading)))});
}

class SlidingPuck : public ::testing::TestWithParam<double> {};

/// Implicit Euler steps against a force of μ m g, in a straight line to rest.
TEST_P(SlidingPuck, ConeSlowsAlikeAlongEveryHeading) {
  const double heading = GetParam();
  const ReadyProblem ready = sliding_puck(heading, "cone");
  const SolveResult result =
      solve(*ready.built.problem, "ipopt", ready.spec.solver.options, ready.built.guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const int nv = ready.built.plant.stepping()->nv();
  double speed = kSpeed, way = 0;
  for (int k = 1; k <= result.trajectory.knots(); ++k) {
    const double h = ready.built.problem->knot(k - 1).dt;
    speed = std::max(0.0, speed - h * kFriction * kGravity);
    way += h * speed;
    const auto x = result.trajectory.x(k);
    EXPECT_NEAR(x[0], way * std::cos(heading), 1e-6) << k;
    EXPECT_NEAR(x[1], way * std::sin(heading), 1e-6) << k;
    EXPECT_NEAR(x[3], 0, 1e-6) << k;  // no rotation
    EXPECT_NEAR(x[nv], speed * std::cos(heading), 1e-6) << k;
    EXPECT_NEAR(x[nv + 1], speed * std::sin(heading), 1e-6) << k;
  }
  EXPECT_EQ(speed, 0);
  // v²/(2 μ g) up to discretization: at most half a step at the initial speed.
  EXPECT_NEAR(way, kSpeed * kSpeed / (2 * kFriction * kGravity), 0.5 * 0.02 * kSpeed);
}

INSTANTIATE_TEST_SUITE_P(Headings, SlidingPuck,
                         ::testing::Values(0.0, 0.3, std::numbers::pi / 4, 2.0, -1.2));

TEST(SlidingPuck, IsTurnedAwayByThePyramid) {
  const double heading = 0.5;
  const ReadyProblem ready = sliding_puck(heading, "polyhedron");
  const SolveResult result =
      solve(*ready.built.problem, "ipopt", ready.spec.solver.options, ready.built.guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const auto end = result.trajectory.x(result.trajectory.knots());
  // All friction first decelerates the faster tangent.
  const auto first = result.trajectory.x(1);
  const int nv = ready.built.plant.stepping()->nv();
  EXPECT_NEAR(first[nv], kSpeed * std::cos(heading) - 0.02 * kFriction * kGravity, 1e-6);
  EXPECT_NEAR(first[nv + 1], kSpeed * std::sin(heading), 1e-6);
  EXPECT_GT(std::abs(std::atan2(end[1], end[0]) - heading), 0.05);
}

}  // namespace
}  // namespace conddp
