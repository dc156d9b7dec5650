// Additional states that integrate a rate.
#include <gtest/gtest.h>

#include "ocp/residuals/expression_residual.hpp"
#include "support/knot_case.hpp"

namespace conddp {
namespace {

/// A pendulum with three more states: the first integrates sin(angle) − velocity², the last
/// velocity × control plus the first.
std::shared_ptr<KnotModel> summing_pendulum(Integrator integrator) {
  const auto system = pendulum({});
  Step step(system, integrator);
  step.hold(3);
  std::vector<KnotName> names = knot_names(*system);
  const std::string angle = names[0].name, velocity = names[1].name, torque = names[2].name;
  names.push_back({.name = "sum", .unit = "", .numbers = {{false, 2}}, .parts = {}});
  const auto add = [&](const std::string& rate, int number) {
    const ParsedExpressionResidual parsed =
        make_expression_residual(step.manifold(), {.names = names, .rows = {rate}});
    if (!parsed.residual) throw std::invalid_argument(parsed.errors.at(0).message.message);
    step.integrate("i", parsed.residual, number);
  };
  add("sin(" + angle + ") - " + velocity + "^2", 0);
  add(velocity + "*" + torque + " + sum", 2);
  return std::make_shared<KnotModel>(std::move(step));
}

TEST(Integrals, GrowByTheStepTimesTheirRates) {
  RandomNumbers random(71);
  for (const Integrator integrator : {Integrator::rk4, Integrator::semi_implicit_euler}) {
    const auto model = summing_pendulum(integrator);
    const KnotCase c = make_case("pendulum", model, random);
    const KnotModel plain(step_with(pendulum({}), integrator, Memory::none, 3));
    KnotWorkspace<double> work(*model), without(plain);
    const KnotInput<double> in{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt};
    plain.evaluate(in, without);
    const double first = c.x[2] + c.dt * (std::sin(c.x[0]) - c.x[1] * c.x[1]);
    const double last = c.x[4] + c.dt * (c.x[1] * c.u[0] + c.x[2]);
    for (const bool derivatives : {false, true}) {
      if (derivatives)
        model->differentiate(in, work, false);
      else
        model->evaluate(in, work);
      EXPECT_EQ(work.next()[0], without.next()[0]);
      EXPECT_EQ(work.next()[1], without.next()[1]);
      EXPECT_NEAR(work.next()[2], first, 1e-15);
      EXPECT_EQ(work.next()[3], c.x[3]);
      EXPECT_NEAR(work.next()[4], last, 1e-15);
    }
  }
}

TEST(Integrals, DerivativesMatchDualNumbers) {
  RandomNumbers random(72);
  for (const Integrator integrator : {Integrator::rk4, Integrator::semi_implicit_euler}) {
    const auto model = summing_pendulum(integrator);
    const KnotCase c = make_case("pendulum", model, random);
    KnotWorkspace<double> work(*model);
    model->differentiate(KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt},
                         work, false);
    const int ndx = model->ndx();
    ASSERT_EQ(model->jacobian_rows(), ndx);
    for (int d = 0; d < model->nz(); ++d) {
      const DirectionalDerivative expected = directional_derivative(c, d);
      for (int i = 0; i < ndx; ++i)
        EXPECT_NEAR(work.F()[d * ndx + i], expected.next[i], 1e-12) << i << ' ' << d;
    }
  }
}

TEST(Integrals, HaveOneRowAndOneHeldNumber) {
  Step step = Step(pendulum({}), Integrator::rk4).hold(1).remember_controls(0, 1);
  EXPECT_THROW(step.integrate("two rows", state_residual(step.manifold()), 0),
               std::invalid_argument);
  const auto torque = control_residual(step.ndx(), step.nu());
  EXPECT_THROW(step.integrate("before", torque, -1), std::invalid_argument);
  EXPECT_THROW(step.integrate("behind", torque, 2), std::invalid_argument);
  EXPECT_THROW(step.integrate("a control", torque, 1), std::invalid_argument);
  step.integrate("torque", torque, 0);
  EXPECT_EQ(step.integrals().size(), 1u);
}

}  // namespace
}  // namespace conddp
