#include <numbers>

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/residuals/residuals.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

/// A quadratic tracking case of ALTRO's benchmarks: weights ½ dt Q, ½ dt R, and ½ Qf, N nodes, and
/// a simulated constant-control guess.
struct Case {
  std::shared_ptr<const System> system;
  Integrator integrator;
  int nodes;
  double duration;
  double Q, R, Qf;
  std::vector<double> start, goal, guess;
};

double initial_cost(const Case& c) {
  const double dt = c.duration / (c.nodes - 1);
  auto model = std::make_shared<KnotModel>(c.system, c.integrator);
  model->add_cost("state", state_residual(c.system->manifold()), {});
  model->add_cost("control", control_residual(c.system->ndx(), c.system->nu()), {});
  auto end = std::make_shared<KnotModel>(c.system, Integrator::none);
  end->add_cost("state", state_residual(c.system->manifold()), {});
  std::vector<double> knot = c.goal, last = c.goal;
  knot.push_back(c.Q);
  knot.insert(knot.end(), c.system->nu(), 0.0);
  knot.push_back(c.R);
  last.push_back(c.Qf);
  Phase phase{
      "all", model, std::vector<double>(c.nodes - 1, dt), std::vector<double>(c.nodes - 1, dt), {}};
  for (int k = 0; k < c.nodes - 1; ++k)
    phase.parameters.insert(phase.parameters.end(), knot.begin(), knot.end());
  const ShootingProblem problem(c.start, {phase}, Phase{"end", end, {0}, {1}, last});
  Trajectory t = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k)
    for (int i = 0; i < problem.nu(k); ++i) t.u(k)[i] = c.guess[i];
  Evaluator evaluator(problem);
  EXPECT_EQ(evaluator.simulate(t), -1);
  Evaluation evaluation(problem);
  evaluator.evaluate(t, evaluation);
  EXPECT_LT(evaluation.gap.cwiseAbs().maxCoeff(), 1e-12);
  return evaluation.cost.sum();
}

constexpr double kPi = std::numbers::pi;

TEST(PublishedCases, PendulumMatchesPublishedCost) {
  EXPECT_NEAR(
      initial_cost({pendulum({}), Integrator::rk4, 51, 3, 1e-3, 1e-3, 1, {0, 0}, {kPi, 0}, {0.1}}),
      4.913747482, 1e-9);
}

TEST(PublishedCases, CartpoleMatchesPublishedCostWithKutta3) {
  EXPECT_NEAR(initial_cost({cartpole({}),
                            Integrator::rk3,
                            101,
                            5,
                            0.01,
                            0.1,
                            100,
                            {0, 0, 0, 0},
                            {0, kPi, 0, 0},
                            {0.01}}),
              494.453188503, 1e-9);
}

TEST(PublishedCases, CartpoleMatchesPublishedCostWithFourthOrder) {
  EXPECT_NEAR(initial_cost({cartpole({}),
                            Integrator::rk4,
                            101,
                            5,
                            0.01,
                            0.1,
                            100,
                            {0, 0, 0, 0},
                            {0, kPi, 0, 0},
                            {0.01}}),
              494.451492216, 1e-9);
}

TEST(PublishedCases, AcrobotMatchesPublishedCost) {
  EXPECT_NEAR(initial_cost({acrobot({}),
                            Integrator::rk4,
                            101,
                            5,
                            1,
                            0.01,
                            100,
                            {-kPi / 2, 0, 0, 0},
                            {kPi / 2, 0, 0, 0},
                            {0}}),
              518.154231057, 1e-9);
}

TEST(PublishedCases, UnicycleAmongThreeObstaclesMatchesPublishedCost) {
  EXPECT_NEAR(
      initial_cost(
          {unicycle(), Integrator::rk4, 101, 5, 1, 0.5, 10, {0, 0, 0}, {3, 3, 0}, {0.01, 0.01}}),
      133.1151550141444, 1e-9);
}

}  // namespace
}  // namespace conddp
