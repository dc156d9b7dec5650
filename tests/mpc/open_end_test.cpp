// Path of the node at the end of windows.
#include "mpc/open_end.hpp"

#include <cmath>
#include <stdexcept>

#include "loop_cases.hpp"

namespace conddp {
namespace {

/// A rotation about z by an angle.
std::vector<double> turned(double angle) {
  return {0, 0, std::sin(angle / 2), std::cos(angle / 2)};
}

TEST(StatePath, TakesTheShortestPathBetweenItsEnds) {
  StateManifold rotations;
  rotations.append(StateManifold::Part::so3);
  const StatePath path{{1, 3, 4}, {turned(0.2), turned(1.2), turned(1.2)}};
  const auto angle_at = [&](double time) {
    std::vector<double> x(4), tangent(3);
    path.state_at(rotations, time, tangent.data(), x.data());
    return 2 * std::atan2(x[2], x[3]);
  };
  EXPECT_DOUBLE_EQ(angle_at(0), 0.2);
  EXPECT_DOUBLE_EQ(angle_at(1), 0.2);
  EXPECT_NEAR(angle_at(1.5), 0.45, 1e-12);
  EXPECT_NEAR(angle_at(3), 1.2, 1e-12);
  EXPECT_NEAR(angle_at(3.5), 1.2, 1e-12);
  EXPECT_DOUBLE_EQ(angle_at(9), 1.2);
}

TEST(OpenEnd, MovesOnlyItsReferences) {
  const auto problem = testing::balanced_cartpole();
  const auto path =
      std::make_shared<StatePath>(StatePath{{0, 2}, {{0, M_PI, 0, 0}, {1, M_PI, 0, 0}}});
  OpenEnd end(problem->terminal(), path);
  end.move_to(0.5);
  std::vector<double> expected = problem->terminal().parameters;
  const CostTerm& cost = problem->terminal().model->costs().front();
  expected[cost.parameters] = 0.25;
  EXPECT_EQ(end.phase().parameters, expected);
  end.follow(nullptr);
  end.move_to(1);
  expected[cost.parameters] = 0.5;
  EXPECT_EQ(end.phase().parameters, expected);
}

TEST(OpenEnd, StaysWithoutAPath) {
  const auto problem = testing::balanced_cartpole();
  OpenEnd end(problem->terminal(), nullptr);
  end.move_to(1);
  EXPECT_EQ(end.phase().parameters, problem->terminal().parameters);
}

TEST(OpenEnd, HasAPathOfStatesOfTheProblem) {
  const auto problem = testing::balanced_cartpole();
  const auto refused = [&](const StatePath& path) {
    EXPECT_THROW(OpenEnd(problem->terminal(), std::make_shared<StatePath>(path)),
                 std::invalid_argument);
  };
  refused({});
  refused({{0, 1}, {{0, M_PI, 0, 0}}});
  refused({{0}, {{0, M_PI}}});
}

}  // namespace
}  // namespace conddp
