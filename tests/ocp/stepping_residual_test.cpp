// The equations of a step that finds its own contacts, and complementary pairs as a constraint.
#include "ocp/stepping_residual.hpp"

#include <gtest/gtest.h>

#include "ocp/knot_model.hpp"
#include "robot/dynamics.hpp"
#include "support/stepping_robot.hpp"

namespace conddp {
namespace {

constexpr double kStep = 0.05;

struct Point {
  std::vector<double> x, w;
};

Point random_point(const SteppingSystem& system, std::uint64_t seed) {
  RandomNumbers random(seed);
  Point p;
  for (int i = 0; i < system.nx(); ++i) p.x.push_back(random.uniform(-1, 1));
  for (int i = 0; i < system.nu(); ++i) p.w.push_back(random.uniform(-2, 2));
  return p;
}

std::vector<double> values(const SteppingSystem& system, const Residual& residual, const Point& p) {
  const auto data = system.create_data(double{});
  system.evaluate(p.x.data(), p.w.data(), *data);
  std::vector<double> r(residual.size());
  residual.evaluate(ResidualInput<double>{p.x.data(), p.w.data(), &kStep, *data}, r.data());
  return r;
}

TEST(SteppingLayout, AlongOneTangentTheConeIsThePyramid) {
  const auto names = [](bool planar, FrictionModel friction) {
    const auto system = stepping_robot(planar, SteppingScheme::backward_euler, friction);
    std::vector<std::string> list;
    for (const Column& column : system->layout().columns) list.push_back(column.name);
    return list;
  };
  EXPECT_EQ(names(true, FrictionModel::cone), names(true, FrictionModel::polyhedron));
  const auto cone = names(false, FrictionModel::cone);
  EXPECT_NE(cone, names(false, FrictionModel::polyhedron));
  EXPECT_EQ(std::count(cone.begin(), cone.end(), "contact/ball/ft2"), 1);
  EXPECT_EQ(std::count(cone.begin(), cone.end(), "contact/pad/ft2"), 0);  // without friction
}

class SteppingDerivatives
    : public ::testing::TestWithParam<std::tuple<bool, SteppingScheme, FrictionModel>> {};

TEST_P(SteppingDerivatives, AgreeWithDifferences) {
  const auto& [planar, scheme, friction] = GetParam();
  const auto system = stepping_robot(planar, scheme, friction);
  const auto residual = stepping_residual(system, system->ndx());
  const Point p = random_point(*system, 3);
  const auto data = system->create_data(double{});
  system->differentiate(p.x.data(), p.w.data(), *data);
  std::vector<double> r(residual->size()), packed(residual->jacobian_size());
  residual->differentiate(ResidualInput<double>{p.x.data(), p.w.data(), &kStep, *data}, r.data(),
                          packed.data());
  const std::vector<double> same = values(*system, *residual, p);
  const int nz = system->ndx() + system->nu();
  std::vector<double> jacobian(residual->size() * nz, 0.0);
  const double* entry = packed.data();
  int first = 0;
  for (const RowBlock& block : residual->blocks()) {
    EXPECT_TRUE(std::is_sorted(block.columns.begin(), block.columns.end()));
    for (const int c : block.columns)
      for (int i = 0; i < block.rows; ++i) jacobian[(first + i) * nz + c] += *entry++;
    first += block.rows;
  }
  const auto names = stepping_row_names(*system);
  ASSERT_EQ(static_cast<int>(names.size()), residual->size());
  for (int c = 0; c < nz; ++c) {
    constexpr double kDifference = 1e-6;
    Point up = p, down = p;
    double& a = c < system->ndx() ? up.x[c] : up.w[c - system->ndx()];
    double& b = c < system->ndx() ? down.x[c] : down.w[c - system->ndx()];
    a += kDifference;
    b -= kDifference;
    const auto above = values(*system, *residual, up), below = values(*system, *residual, down);
    for (int i = 0; i < residual->size(); ++i) {
      EXPECT_EQ(r[i], same[i]);
      EXPECT_NEAR(jacobian[i * nz + c], (above[i] - below[i]) / (2 * kDifference), 2e-6)
          << names[i] << " by column " << c;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, SteppingDerivatives,
                         ::testing::Combine(::testing::Bool(),
                                            ::testing::Values(SteppingScheme::backward_euler,
                                                              SteppingScheme::variational_midpoint),
                                            ::testing::Values(FrictionModel::polyhedron,
                                                              FrictionModel::cone)));

/// Momentum is ∂T/∂v, the load what bias forces are without the change of the momentum, and both
/// follow from kinetic energy alone by differences.
TEST(HalfStep, IsThatOfKineticEnergy) {
  const auto system = stepping_robot(false, SteppingScheme::variational_midpoint);
  RobotModel robot = system->multibody().robot();
  robot.wrenches.clear();  // they have no energy
  RobotModel free = robot;
  free.gravity = Vector3<double>::zero();
  RandomNumbers random(9);
  std::vector<double> q(robot.nq), v(robot.nv);
  for (double& x : q) x = random.uniform(-1, 1);
  for (double& x : v) x = random.uniform(-2, 2);
  const auto energy = [&](const std::vector<double>& at, const std::vector<double>& speed) {
    RobotData<double> data(robot);
    update_placements(robot, at.data(), data);
    update_velocities(robot, speed.data(), data);
    update_composite_inertias(robot, data);
    return kinetic_energy(robot, data) - potential_energy(robot, data);
  };
  HalfStep<double> half(robot);
  std::copy(q.begin(), q.end(), half.position.begin());
  update_half_step(robot, free, v.data(), false, half);
  constexpr double kDifference = 1e-6;
  for (int i = 0; i < robot.nv; ++i) {
    const auto slope = [&](std::vector<double>& x) {
      const double before = x[i];
      x[i] = before + kDifference;
      const double above = energy(q, v);
      x[i] = before - kDifference;
      const double below = energy(q, v);
      x[i] = before;
      return (above - below) / (2 * kDifference);
    };
    EXPECT_NEAR(half.momentum[i], slope(v), 1e-7) << i;
    EXPECT_NEAR(half.load[i], -slope(q), 1e-6) << i;
  }
}

TEST(SteppingResidual, EquationsOfMotionAreThoseOfInverseDynamics) {
  const auto system = stepping_robot(true);
  Point p = random_point(*system, 5);
  const SteppingLayout& layout = system->layout();
  for (std::size_t i = layout.acceleration + layout.nv; i < p.w.size(); ++i) p.w[i] = 0;
  const std::vector<double> r = values(*system, *stepping_residual(system, system->ndx()), p);
  const RobotModel& model = system->multibody().robot();
  std::vector<double> q(layout.nv), v(layout.nv), a(layout.nv);
  for (int i = 0; i < layout.nv; ++i) {
    a[i] = p.w[layout.acceleration + i];
    v[i] = p.x[layout.nv + i] + kStep * a[i];
    q[i] = p.x[i] + kStep * v[i];
  }
  RobotData<double> data(model);
  inverse_dynamics(model, q.data(), v.data(), a.data(), data);
  const std::vector<double>& B = system->multibody().actuation().B;
  for (int i = 0; i < layout.nv; ++i) {
    double expected = data.tau[i];
    for (int c = 0; c < layout.actuators; ++c) expected -= B[c * layout.nv + i] * p.w[c];
    EXPECT_NEAR(r[i], expected, 1e-10) << i;
  }
}

TEST(ComplementarityConstraint, MeasuresTheSmallerOneOfEachPair) {
  const auto term = make_constraint("pairs", chosen_controls_residual(2, {0, 1, 3, 2}),
                                    ConstraintKind::complementarity);
  EXPECT_EQ(term.rows, 4);
  const auto distance = [&](std::vector<double> g) {
    return distance_to_set(term, g.data(), nullptr, nullptr);
  };
  EXPECT_EQ(distance({0, 5, 3, 0}), 0);
  EXPECT_EQ(distance({1e-3, 5, 3, 0}), 1e-3);
  EXPECT_EQ(distance({0, 5, 3, -0.2}), 0.2);
  EXPECT_TRUE(std::isnan(distance({0, 5, std::nan(""), 1})));
  const std::vector<double> g = {0, 5, 3, 0};
  const auto product = [&](std::vector<double> nu) {
    return complementarity(term, g.data(), nullptr, nullptr, nu.data());
  };
  EXPECT_EQ(product({-7, 0, 0, 8}), 0);  // what is zero may have a multiplier of either sign
  EXPECT_EQ(product({0, 2, 0, 0}), 10);
  EXPECT_THROW(make_constraint("odd", chosen_controls_residual(2, {0, 1, 2}),
                               ConstraintKind::complementarity),
               std::invalid_argument);
}

}  // namespace
}  // namespace conddp
