// The residual that compares a state with a first one that was chosen.
#include <gtest/gtest.h>

#include "support/knot_case.hpp"

namespace conddp {
namespace {

struct Cycle {
  std::shared_ptr<const MultibodySystem> system;
  ChosenStart start;
  std::vector<double> offset;
};

/// A robot of which some coordinates of the first state were free, by their tangent indices.
Cycle cycle_of(bool floating, RandomNumbers& random) {
  const auto robot = std::make_shared<RobotModel>(
      random_robot(81, {.joints = 4, .floating = floating, .wrenches = 0}));
  Cycle cycle{std::make_shared<MultibodySystem>(robot, Actuation::full(*robot)), {}, {}};
  const StateManifold& manifold = cycle.system->manifold();
  cycle.start.state = random_manifold_state(manifold, random, 1);
  cycle.start.coordinates = {1, 3, manifold.ndx() - 2};
  if (floating) cycle.start.coordinates = {4, 0, 7, manifold.ndx() - 1};
  cycle.offset.assign(manifold.nx(), 0.0);
  for (int i = 0; i < manifold.nx(); ++i)
    if (!floating || i < 3 || i > 6) cycle.offset[i] = random.uniform(-1, 1);
  return cycle;
}

TEST(CycleResidual, IsTheWayFromTheChosenStartWithItsOffset) {
  RandomNumbers random(41);
  for (const bool floating : {false, true}) {
    const Cycle cycle = cycle_of(floating, random);
    const StateManifold& manifold = cycle.system->manifold();
    const auto residual = cycle_residual(manifold, cycle.start, cycle.offset);
    const std::vector<double> chosen = random.numbers(cycle.start.coordinates.size(), 1);
    std::vector<double> step(manifold.ndx(), 0.0), x = cycle.start.state;
    for (std::size_t i = 0; i < chosen.size(); ++i) step[cycle.start.coordinates[i]] = chosen[i];
    manifold.integrate(x.data(), step.data(), x.data());
    for (int i = 0; i < manifold.nx(); ++i) x[i] += cycle.offset[i];
    std::vector<double> way(manifold.ndx());
    for (double& d : way) d = random.uniform(-0.7, 0.7);
    manifold.integrate(x.data(), way.data(), x.data());
    x.insert(x.end(), chosen.begin(), chosen.end());
    const auto data = cycle.system->create_data(double{});
    std::vector<double> r(residual->size());
    ASSERT_EQ(residual->size(), manifold.ndx());
    residual->evaluate(ResidualInput<double>{x.data(), nullptr, nullptr, *data}, r.data());
    for (int i = 0; i < manifold.ndx(); ++i) EXPECT_NEAR(r[i], way[i], 1e-12) << "row " << i;
  }
}

TEST(CycleResidual, GradientsAreThoseOfDualNumbers) {
  RandomNumbers random(42);
  for (const bool floating : {false, true}) {
    const Cycle cycle = cycle_of(floating, random);
    auto model = std::make_shared<KnotModel>(cycle.system, Integrator::semi_implicit_euler,
                                             ControlMemory::none,
                                             static_cast<int>(cycle.start.coordinates.size()));
    model->add_cost("cycle", cycle_residual(cycle.system->manifold(), cycle.start, cycle.offset),
                    {});
    const KnotCase c = make_case("cycle", model, random);
    KnotWorkspace<double> work(*model);
    model->differentiate(KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt},
                         work, true);
    double scale = 1;
    for (double g : work.gradient) scale = std::max(scale, std::abs(g));
    for (int d = 0; d < model->nz(); ++d)
      EXPECT_NEAR(work.gradient[d], directional_derivative(c, d).cost, 1e-10 * scale)
          << (floating ? "floating" : "fixed") << " direction " << d;
  }
}

}  // namespace
}  // namespace conddp
