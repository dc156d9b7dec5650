#include "mpc/appraisal.hpp"

#include <gtest/gtest.h>

#include "loop_cases.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

/// ½ q² along q = 1 + t over parts of knots of 0.4 s.
TEST(Appraisal, IntegratesCostsOverTheStep) {
  const auto system = double_integrator(1);
  const auto model = std::make_shared<KnotModel>(system, Integrator::rk4);
  model->add_cost("q", coordinate_residual(model->manifold(), {0}), {}, {}, true);
  std::vector<double> parameters(2 * model->parameter_count(), 0.0);
  for (const int knot : {0, 1})
    parameters[knot * model->parameter_count() + model->costs()[0].weight] = 1;
  Phase phase{.name = "move", .model = model, .dt = {0.4, 0.4}, .cost_scale = {0.4, 0.4}};
  phase.parameters = parameters;
  const TimeLine line(testing::shared(ShootingProblem(
                          {1, 1}, {std::move(phase)},
                          {.name = "end",
                           .model = std::make_shared<KnotModel>(system, Integrator::none),
                           .dt = {0},
                           .cost_scale = {1}})),
                      false);
  const Appraisal appraisal(line, false);
  const double u = 0;
  for (const double begin : {0.0, 0.1, 0.4})
    for (const double length : {0.1, 0.3, 0.4}) {
      const double x[] = {1 + begin, 1}, end = x[0] + length;
      EXPECT_NEAR(appraisal.of_step(begin, length, &u, x).cost,
                  (end * end * end - x[0] * x[0] * x[0]) / 6, 1e-14)
          << begin << " " << length;
    }
}

}  // namespace
}  // namespace conddp
