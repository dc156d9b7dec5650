#include "ocp/problem/problem.hpp"

#include <stdexcept>

#include <gtest/gtest.h>

#include "ocp/problem/contradiction.hpp"
#include "ocp/residuals/residuals.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

std::vector<double> steps(int count, double step) { return std::vector<double>(count, step); }

TEST(NodeTimes, AreTheExpectedDecimalNumbers) {
  EXPECT_EQ(node_times(steps(50, 0.06)).back(), 3.0);
  EXPECT_EQ(node_times(steps(3, 0.1)).back(), 0.3);
  EXPECT_EQ(node_times(steps(1'000'000, 0.001)).back(), 1000.0);
  const std::vector<double> times = node_times(steps(500, 0.02));
  ASSERT_EQ(times.size(), 501u);
  EXPECT_EQ(times[0], 0);
  for (int k = 0; k <= 500; ++k) EXPECT_EQ(times[k], std::stod(std::to_string(2 * k) + "e-2")) << k;
}

TEST(NodeTimes, AddUpDifferentSteps) {
  std::vector<double> mixed = steps(30, 0.01);
  mixed.insert(mixed.end(), 7, 0.3);
  mixed.insert(mixed.end(), 3, 1.0 / 3);
  EXPECT_EQ(node_times(mixed)[37], 2.4);
  EXPECT_NEAR(node_times(mixed).back(), 3.4, 1e-15);
  EXPECT_EQ(node_times({}), std::vector<double>{0});
}

constexpr double kNone = std::numeric_limits<double>::infinity();

/// A phase without costs; the parameters belong to terms added to the model.
Phase phase_of(std::shared_ptr<KnotModel> model, std::vector<double> dt,
               std::vector<double> parameters = {}) {
  Phase phase{.name = "phase", .model = std::move(model), .dt = std::move(dt)};
  phase.cost_scale.assign(phase.dt.size(), 2);
  for (std::size_t k = 0; k < phase.dt.size(); ++k)
    phase.parameters.insert(phase.parameters.end(), parameters.begin(), parameters.end());
  return phase;
}
std::shared_ptr<KnotModel> masses(int count, Integrator integrator) {
  return std::make_shared<KnotModel>(double_integrator(count), integrator);
}

TEST(ShootingProblem, ReportsInconsistentSizes) {
  const auto model = masses(1, Integrator::rk4), end = masses(1, Integrator::none);
  const auto make = [&](std::vector<double> x, Phase phase, Phase terminal) {
    return ShootingProblem(std::move(x), {std::move(phase)}, std::move(terminal));
  };
  EXPECT_EQ(make({0, 0}, phase_of(model, {1, 2}), phase_of(end, {0})).knots(), 2);
  const auto expect_misfit = [&](std::vector<double> x, const Phase& phase, const Phase& terminal) {
    EXPECT_THROW(make(std::move(x), phase, terminal), std::invalid_argument);
  };
  const Phase good = phase_of(model, {1, 2}), last = phase_of(end, {0});
  expect_misfit({0, 0, 0}, good, last);
  expect_misfit({0, 0}, phase_of(nullptr, {1}), last);
  expect_misfit({0, 0}, phase_of(model, {}), last);
  expect_misfit({0, 0}, phase_of(model, {1}, {3}), last);
  expect_misfit({0, 0}, phase_of(masses(2, Integrator::rk4), {1}), last);
  expect_misfit({0, 0}, good, phase_of(model, {0}));
  expect_misfit({0, 0}, good, phase_of(end, {0, 0}));
  Phase unscaled = good;
  unscaled.cost_scale.pop_back();
  expect_misfit({0, 0}, unscaled, last);
}

TEST(ShootingProblem, BeginsAtTheGivenState) {
  ShootingProblem problem({1, 2}, {phase_of(masses(1, Integrator::rk4), {1, 1})},
                          phase_of(masses(1, Integrator::none), {0}));
  problem.set_initial_state(std::vector<double>{3, 4});
  EXPECT_EQ(problem.initial_state(), (std::vector<double>{3, 4}));
  EXPECT_THROW(problem.set_initial_state(std::vector<double>{3}), std::invalid_argument);
  const Trajectory start = problem.create_trajectory();
  ASSERT_EQ(start.knots(), 2);
  for (int k = 0; k <= 2; ++k) EXPECT_EQ(start.x(k), Eigen::Vector2d(3, 4)) << k;
  EXPECT_EQ(start.u(1), Eigen::VectorXd::Zero(1));
}

TEST(ShootingProblem, AcceptsOtherNumbersForItsNodes) {
  const auto model = masses(1, Integrator::rk4);
  model->add_cost("effort", control_residual(2, 1), {});
  ShootingProblem problem({1, 2}, {phase_of(model, {1, 1}, {0, 3})},
                          phase_of(masses(1, Integrator::none), {0}));
  const double first[] = {5, 6}, second[] = {7, 8};
  const std::vector<KnotNumbers> numbers = {{0.25, 4, first}, {0.5, 9, second}, {0, 1, nullptr}};
  problem.set_numbers(numbers);
  EXPECT_EQ(problem.times(), (std::vector<double>{0, 0.25, 0.75}));
  EXPECT_EQ(problem.phases()[0].dt, (std::vector<double>{0.25, 0.5}));
  EXPECT_EQ(problem.knot(0).cost_scale, 4);
  EXPECT_EQ(problem.knot(0).parameters[1], 6);
  EXPECT_EQ(problem.knot(1).dt, 0.5);
  EXPECT_EQ(problem.knot(1).parameters[0], 7);
  EXPECT_THROW(problem.set_numbers({numbers.data(), 2}), std::invalid_argument);
}

TEST(ShootingProblem, KnowsInstantaneousAndBoundedKnots) {
  const auto model = masses(1, Integrator::semi_implicit_euler);
  Phase instant = phase_of(model, {1});
  instant.instant = true;
  const auto end = phase_of(masses(1, Integrator::none), {0});
  const ShootingProblem free({0, 0}, {phase_of(model, {0.5}), instant, phase_of(model, {0.25})},
                             end);
  EXPECT_EQ(free.times(), (std::vector<double>{0, 0.5, 0.5, 0.75}));
  EXPECT_FALSE(free.takes_no_time(0));
  EXPECT_TRUE(free.takes_no_time(1));
  EXPECT_FALSE(free.takes_no_time(2));
  EXPECT_FALSE(free.has_control_bounds());
  EXPECT_FALSE(free.has_free_durations());
  const Trajectory any = free.create_trajectory();
  EXPECT_EQ(free.times(any), free.times());

  for (const bool below : {false, true}) {
    const auto bounded = masses(1, Integrator::rk4);
    bounded->set_control_bounds({below ? -1 : -kNone}, {below ? kNone : 1});
    const ShootingProblem held({0, 0}, {phase_of(model, {1}), phase_of(bounded, {1})}, end);
    EXPECT_TRUE(held.has_control_bounds());
  }
}

/// One knot and the terminal node of a mass with x = (position, velocity) and separate state
/// bounds: lower position, lower velocity, upper position, upper velocity.
struct HeldMass {
  std::shared_ptr<KnotModel> running = masses(1, Integrator::rk4),
                             end = masses(1, Integrator::none);
  std::vector<double> of_knot, of_end;

  void hold(const std::string& name, std::vector<double> lower, std::vector<double> upper,
            bool at_end, std::vector<double> reference = {0, 0}) {
    KnotModel& model = at_end ? *end : *running;
    model.add_constraint(
        make_constraint(name, state_residual(model.manifold()), ConstraintKind::bounds));
    std::vector<double>& all = at_end ? of_end : of_knot;
    for (const auto& part : {reference, lower, upper, {1.0}})
      all.insert(all.end(), part.begin(), part.end());
  }
  void hold_control(const std::string& name, double lower, double upper) {
    running->add_constraint(make_constraint(name, control_residual(2, 1), ConstraintKind::bounds));
    for (const double each : {0.5, lower, upper, 1.0}) of_knot.push_back(each);
  }
  std::optional<Contradiction> find() const {
    return find_contradiction(ShootingProblem({0.25, -0.5}, {phase_of(running, {1}, of_knot)},
                                              phase_of(end, {0}, of_end)));
  }
};

TEST(Contradiction, IsFoundBetweenBoundsOnOneCoordinate) {
  HeldMass mass;
  mass.hold("first", {-1, -2}, {1, 2}, true);
  mass.hold("narrower", {-3, 0.5}, {3, 4}, true);
  mass.hold("low", {-1, -5}, {1, 3.25}, true, {0, -3});  // velocity at most 0.25
  const auto found = mass.find();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->first, "low");
  EXPECT_EQ(found->second, "narrower");
  EXPECT_EQ(found->node, 1);
  EXPECT_NEAR(found->lower, 3.5, 1e-15);  // measured by "low" from −3
  EXPECT_NEAR(found->upper, 3.25, 1e-15);
}

TEST(Contradiction, IsFoundOnEitherSide) {
  HeldMass mass;
  mass.hold("first", {-1, -2}, {1, 2}, false);
  mass.hold("above", {1.5, -2}, {3, 2}, false);
  const auto found = mass.find();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->first, "above");
  EXPECT_EQ(found->second, "first");
  EXPECT_EQ(found->node, 0);
  EXPECT_NEAR(found->lower, 1.5, 1e-15);
  EXPECT_NEAR(found->upper, 1, 1e-15);
}

TEST(Contradiction, IgnoresTouchingBoundsAndOtherCoordinatesOrNodes) {
  HeldMass mass;
  mass.hold("first", {-1, 0.1}, {1, 2}, true);
  for (const double r : {0.0, 0.1, 0.3, 0.7, 1.1})  // up to rounding
    mass.hold("meets", {1 - r, -kNone}, {3, 0.1 - r}, true, {r, r});
  mass.hold("elsewhere", {-kNone, 5}, {-4, kNone}, false);
  // Bounds on sums of coordinates do not bound the coordinates.
  mass.end->add_constraint(make_constraint(
      "sum", combination_residual(2, {{.terms = {{1, false, 0, 0}, {1, false, 1, 1}}}}),
      ConstraintKind::bounds));
  mass.of_end.insert(mass.of_end.end(), {5, 6, 1});
  EXPECT_FALSE(mass.find());
  EXPECT_FALSE(HeldMass{}.find());
}

TEST(Contradiction, IsFoundWithTheBoundsOnTheControl) {
  for (const bool above : {false, true}) {
    HeldMass mass;
    mass.running->set_control_bounds({-1}, {2});
    if (above)
      mass.hold_control("force", 1.75, 5);  // a force of at least 2.25
    else
      mass.hold_control("force", -5, -1.75);
    const auto found = mass.find();
    ASSERT_TRUE(found);
    EXPECT_EQ(found->first, "force");
    EXPECT_EQ(found->second, "");
    EXPECT_NEAR(found->lower, above ? 1.75 : -1.5, 1e-15);
    EXPECT_NEAR(found->upper, above ? 1.5 : -1.75, 1e-15);
  }
  HeldMass mass;
  mass.running->set_control_bounds({-1}, {2});
  mass.hold_control("force", 1.5, 5);
  EXPECT_FALSE(mass.find());
}

}  // namespace
}  // namespace conddp
