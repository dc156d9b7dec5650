// A phase whose duration is part of the state.
#include <gtest/gtest.h>

#include "support/knot_case.hpp"

namespace conddp {
namespace {

/// A pendulum with costs on its state and control, and additional held states.
std::shared_ptr<KnotModel> held_pendulum(Integrator integrator, int held,
                                         const std::optional<FreeDuration>& grows_with = {},
                                         const std::optional<FreeDuration>& scales_time = {}) {
  Step step = step_with(pendulum({}), integrator, Memory::none, held);
  if (scales_time) step.scale_time(*scales_time);
  auto model = std::make_shared<KnotModel>(std::move(step));
  model->add_cost("state", state_residual(model->manifold()), {}, grows_with);
  model->add_cost("control", control_residual(model->ndx(), model->nu()), {}, grows_with);
  return model;
}

struct Outcome {
  std::vector<double> next;
  double cost;
};

Outcome outcome_of(const KnotModel& model, const KnotCase& c, double dt, double cost_scale) {
  KnotWorkspace<double> work(model);
  model.evaluate(KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), dt, cost_scale},
                 work);
  return {{work.next().begin(), work.next().end()}, work.cost};
}

TEST(FreeDuration, ScalesStepsAndCostsByTheWrittenOne) {
  RandomNumbers random(51);
  for (const bool scales_cost : {true, false}) {
    const FreeDuration duration{.choice = 1, .written = 2};
    const auto plain = held_pendulum(Integrator::rk4, 2);
    const auto free = held_pendulum(Integrator::rk4, 2,
                                    scales_cost ? std::optional(duration) : std::nullopt, duration);
    KnotCase c = make_case("pendulum", free, random);
    c.x[2] = 0.4;
    c.x[3] = 3;  // s, instead of 2
    const Outcome found = outcome_of(*free, c, 0.1, 0.1);
    const Outcome expected = outcome_of(*plain, c, 0.15, scales_cost ? 0.15 : 0.1);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(found.next[i], expected.next[i], 1e-14) << i;
    EXPECT_EQ(found.next[2], 0.4);
    EXPECT_EQ(found.next[3], 3);
    EXPECT_NEAR(found.cost, expected.cost, 1e-14);
  }
}

TEST(FreeDuration, DerivativesMatchDualNumbers) {
  RandomNumbers random(52);
  for (const Integrator integrator :
       {Integrator::rk4, Integrator::explicit_euler, Integrator::semi_implicit_euler})
    for (const bool free : {false, true})
      for (const bool scales_cost : {true, false}) {
        const FreeDuration duration{.choice = 1, .written = 2};
        const std::optional<FreeDuration> none;
        const auto model =
            held_pendulum(integrator, 2, scales_cost ? duration : none, free ? duration : none);
        KnotCase c = make_case("pendulum", model, random);
        c.x[3] = 2.5;
        KnotWorkspace<double> work(*model);
        model->differentiate(
            KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt}, work, true);
        const int ndx = model->ndx();
        ASSERT_EQ(model->jacobian_rows(), ndx);
        for (int d = 0; d < model->nz(); ++d) {
          const DirectionalDerivative expected = directional_derivative(c, d);
          EXPECT_NEAR(work.gradient[d], expected.cost, 1e-11) << "direction " << d;
          for (int i = 0; i < ndx; ++i)
            EXPECT_NEAR(work.F()[d * ndx + i], expected.next[i], 1e-12)
                << "row " << i << " direction " << d;
        }
      }
}

TEST(FreeDuration, TimesOfATrajectoryFollowItsStates) {
  const auto model =
      held_pendulum(Integrator::rk4, 1, {}, FreeDuration{.choice = 0, .written = 0.4});
  auto end =
      std::make_shared<KnotModel>(step_with(pendulum({}), Integrator::none, Memory::none, 1));
  std::vector<double> parameters(2 * model->parameter_count(), 0.0);
  std::vector<Phase> phases;
  phases.push_back({.name = "swing",
                    .model = model,
                    .dt = {0.1, 0.3},
                    .cost_scale = {0.1, 0.3},
                    .parameters = parameters});
  const ShootingProblem problem({0, 0, 0.4}, std::move(phases),
                                {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}});
  EXPECT_TRUE(problem.has_free_durations());
  Trajectory trajectory = problem.create_trajectory();
  for (int k = 0; k <= 2; ++k) trajectory.x(k)[2] = 0.8;
  const std::vector<double> times = problem.times(trajectory);
  ASSERT_EQ(times.size(), 3u);
  EXPECT_NEAR(times[1], 0.2, 1e-15);
  EXPECT_NEAR(times[2], 0.8, 1e-15);
}

}  // namespace
}  // namespace conddp
