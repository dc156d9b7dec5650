// Steps with numbers behind the system's state: each decoration alone, and all of them in pairs.
#include "ocp/step/step.hpp"

#include <functional>

#include <gtest/gtest.h>

#include "support/knot_case.hpp"

namespace conddp {
namespace {

/// A row of velocity, control, and the first number of the tail.
std::shared_ptr<const Residual> rate_of(const Step& step) {
  const System& system = step.system();
  LinearCombination row;
  row.terms = {{2, false, system.nq(), system.ndx() - system.nv()},
               {0.5, false, system.nx(), system.ndx()},
               {-1, true, 0, 0}};
  return combination_residual(step.control_column(0), {row});
}

struct Decoration {
  std::string name;
  std::function<void(Step&)> decorate;
  bool needs_stages = false;  ///< of the integrator
};

std::vector<Decoration> decorations() {
  return {
      {"held", [](Step& step) { step.hold(2); }},
      {"previous", [](Step& step) { step.remember_controls(0, 1); }},
      {"linear", [](Step& step) { step.make_controls_linear(); }, true},
      {"duration",
       [](Step& step) { step.hold(1).scale_time({.choice = step.tail() - 1, .written = 0.8}); }},
      {"held twice", [](Step& step) { step.hold(1).hold(1); }}};
}

/// Makes the first number of the tail an integral, if it stays.
Step with_integral(Step step) {
  if (!step.source(0)) step.integrate("sum", rate_of(step), 0);
  return step;
}

std::vector<std::shared_ptr<const System>> systems() {
  const auto flying =
      std::make_shared<RobotModel>(random_robot(4, {.joints = 2, .floating = true, .wrenches = 1}));
  return {cartpole({}), std::make_shared<MultibodySystem>(flying, Actuation::full(*flying))};
}

/// Columns of F by central differences.
Eigen::MatrixXd differences(const KnotCase& c) {
  constexpr double kChange = 1e-6;
  const KnotModel& model = *c.model;
  KnotWorkspace<double> work(model);
  Eigen::MatrixXd F(model.ndx(), model.nz());
  for (int d = 0; d < model.nz(); ++d) {
    std::vector<double> next[2];
    for (const int side : {0, 1}) {
      std::vector<double> x = c.x, u = c.u, dx(model.ndx(), 0.0);
      (d < model.ndx() ? dx[d] : u[d - model.ndx()]) += side == 0 ? -kChange : kChange;
      model.manifold().integrate(x.data(), dx.data(), x.data());
      model.evaluate(KnotInput<double>{x.data(), u.data(), c.parameters.data(), c.dt, c.dt}, work);
      next[side].assign(work.next().begin(), work.next().end());
    }
    Eigen::VectorXd off(model.ndx());
    model.manifold().difference(next[0].data(), next[1].data(), off.data());
    F.col(d) = off / (2 * kChange);
  }
  return F;
}

void expect_derivatives(Step step, RandomNumbers& random) {
  KnotCase c = make_case("step", std::make_shared<KnotModel>(std::move(step)), random);
  if (const auto& duration = c.model->step().duration())
    c.x[c.model->system().nx() + duration->choice] = 1.1;
  const KnotModel& model = *c.model;
  KnotWorkspace<double> work(model);
  model.differentiate(KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt},
                      work, true);
  ASSERT_EQ(model.jacobian_rows(), model.ndx());
  const Eigen::Map<const Eigen::MatrixXd> F(work.F().data(), model.ndx(), model.nz());
  const double size = F.lpNorm<Eigen::Infinity>();
  for (int d = 0; d < model.nz(); ++d)
    EXPECT_LT((F.col(d) - directional_derivative(c, d).next).lpNorm<Eigen::Infinity>(),
              1e-11 * size)
        << "direction " << d;
  EXPECT_LT((F - differences(c)).lpNorm<Eigen::Infinity>(), 1e-6 * size);
}

TEST(Step, DerivativesOfDecorationsAndPairsAreExact) {
  RandomNumbers random(61);
  for (const auto& system : systems())
    for (const Integrator rule : {Integrator::rk4, Integrator::semi_implicit_euler})
      for (const Decoration& first : decorations()) {
        if (first.needs_stages && !follows_controls(rule)) continue;
        SCOPED_TRACE(first.name);
        Step alone(system, rule);
        first.decorate(alone);
        expect_derivatives(alone, random);
        expect_derivatives(with_integral(alone), random);
        for (const Decoration& second : decorations()) {
          if (second.name == first.name || (second.needs_stages && !follows_controls(rule)))
            continue;
          SCOPED_TRACE(second.name);
          Step both = alone;
          second.decorate(both);
          expect_derivatives(both, random);
          expect_derivatives(with_integral(both), random);
        }
      }
}

TEST(Step, AllDecorationsComposeInAnyOrder) {
  RandomNumbers random(62);
  std::vector<Decoration> all = decorations();
  for (std::size_t turn = 0; turn < all.size(); ++turn) {
    Step step(cartpole({}), Integrator::rk4);
    for (const Decoration& decoration : all) decoration.decorate(step);
    expect_derivatives(with_integral(step), random);
    std::rotate(all.begin(), all.begin() + 1, all.end());
  }
}

TEST(Step, TailStaysOrBecomesControls) {
  const Step step = Step(cartpole({}), Integrator::rk4).hold(1).remember_controls(0, 1).hold(1);
  const KnotModel model(step);
  KnotWorkspace<double> work(model);
  const double x[] = {0, 0, 0, 0, 7, 8, 9}, u[] = {3};
  model.evaluate(KnotInput<double>{x, u, nullptr, 0.1, 1}, work);
  EXPECT_EQ(work.next()[4], 7);
  EXPECT_EQ(work.next()[5], 3);
  EXPECT_EQ(work.next()[6], 9);
  EXPECT_EQ(step.held_columns(), (std::vector<int>{4, 6}));
  EXPECT_EQ(step.source(1), 0);
}

TEST(Step, InstantaneousKnotsHandTheTailOn) {
  const auto robot =
      std::make_shared<RobotModel>(random_robot(4, {.joints = 2, .floating = true, .wrenches = 1}));
  const std::vector<Contact> contacts{
      {.name = "point", .frame = static_cast<int>(robot->frames.size()) - 1}};
  RandomNumbers random(63);
  const auto model = std::make_shared<KnotModel>(
      Step(std::make_shared<MultibodySystem>(robot, contacts, 0.5), Integrator::impulse).hold(2));
  const KnotCase c = make_case("impulse", model, random);
  KnotWorkspace<double> work(*model);
  model->differentiate(KnotInput<double>{c.x.data(), nullptr, c.parameters.data(), 0, 1}, work,
                       false);
  const int n = model->ndx(), own = model->system().nx();
  for (const int i : {0, 1}) EXPECT_EQ(work.next()[own + i], c.x[own + i]);
  for (int d = 0; d < n; ++d) {
    const DirectionalDerivative expected = directional_derivative(c, d);
    for (int i = 0; i < n; ++i) EXPECT_NEAR(work.F()[d * n + i], expected.next[i], 1e-10);
  }
}

TEST(Step, OtherRulesKeepTheTail) {
  RandomNumbers random(64);
  Step timed = Step(cartpole({}), Integrator::rk4).hold(2).remember_controls(0, 1);
  timed.scale_time({.choice = 1, .written = 0.8}).integrate("sum", rate_of(timed), 0);
  expect_derivatives(timed.with(Integrator::explicit_euler), random);
  const Step end = timed.without_dynamics();
  EXPECT_EQ(end.ndx(), timed.ndx());
  EXPECT_EQ(end.nu() + end.jacobian_rows() + end.parameter_count(), 0);
  EXPECT_TRUE(end.integrals().empty() && !end.duration());
  const Step alike = timed.alike(pendulum({}), Integrator::semi_implicit_euler);
  EXPECT_EQ(alike.tail(), 0);
  EXPECT_EQ(alike.integrator(), Integrator::semi_implicit_euler);
}

TEST(Step, RefusesDecorationsWithoutMeaning) {
  EXPECT_THROW(Step(cartpole({}), Integrator::rk4).remember_controls(1, 1), std::invalid_argument);
  EXPECT_THROW(Step(cartpole({}), Integrator::rk4).scale_time({.choice = 0, .written = 1}),
               std::invalid_argument);
  EXPECT_THROW(Step(cartpole({}), Integrator::rk4).remember_controls(0, 1).scale_time({0, 1}),
               std::invalid_argument);
  EXPECT_THROW(with_integral(Step(cartpole({}), Integrator::rk4).hold(1)).hold(1),
               std::invalid_argument);
  const Step linear = Step(cartpole({}), Integrator::rk4).make_controls_linear();
  EXPECT_THROW(linear.with(Integrator::explicit_euler), std::invalid_argument);
  const Step timed = Step(cartpole({}), Integrator::rk4).hold(1).scale_time({0, 1});
  EXPECT_THROW(timed.with(Integrator::none), std::invalid_argument);
}

}  // namespace
}  // namespace conddp
