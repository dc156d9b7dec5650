// A double integrator under zero-order hold with Q = I, R = 0.1 as rates, and dt = 0.1. Windows end
// with ½ xᵀ P x, where P solves the discrete algebraic Riccati equation. The closed loop is that of
// the infinite horizon, whose cost follows from the equation.
#include <gtest/gtest.h>

#include "loop_cases.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

constexpr double kStep = 0.1;

struct Discrete {
  Eigen::MatrixXd A = (Eigen::MatrixXd(2, 2) << 1, kStep, 0, 1).finished();
  Eigen::MatrixXd B = (Eigen::MatrixXd(2, 1) << kStep * kStep / 2, kStep).finished();
  Eigen::MatrixXd Q = kStep * Eigen::MatrixXd::Identity(2, 2);
  double R = kStep * 0.1;

  /// Fixed point of the Riccati recursion.
  Eigen::MatrixXd value() const {
    Eigen::MatrixXd P = Q;
    for (int i = 0; i < 10'000; ++i) {
      const Eigen::MatrixXd K = (B.transpose() * P * A) / ((B.transpose() * P * B)(0, 0) + R);
      P = Q + A.transpose() * P * (A - B * K);
    }
    return P;
  }
};

/// Residual Lᵀ x with P = L Lᵀ, so that ½ ‖·‖² is ½ xᵀ P x.
class Root : public ResidualBase<Root> {
 public:
  explicit Root(const Eigen::MatrixXd& P)
      : ResidualBase({{.rows = 2, .columns = {0, 1}}}, 0, false), Lt_(P.llt().matrixU()) {}
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (int i = 0; i < 2; ++i) r[i] = S(Lt_(i, 0)) * in.x[0] + S(Lt_(i, 1)) * in.x[1];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) jacobian[2 * j + i] = S(Lt_(i, j));
  }

 private:
  Eigen::MatrixXd Lt_;
};

std::shared_ptr<const ShootingProblem> regulator(double limit) {
  const Discrete discrete;
  const auto system = linear_system(discrete.A, discrete.B, Eigen::VectorXd::Zero(2));
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  end->add_cost("value", std::make_shared<Root>(discrete.value()), {});
  return testing::shared(ShootingProblem(
      {1, 0},
      {testing::tracking_phase(system, Integrator::discrete, 10, kStep, {{0, 0}, {1, 1}, {0.1}, {}},
                               -limit, limit)},
      {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}, .parameters = {1}}));
}

MpcOptions options_of(const ShootingProblem& problem, int knots) {
  MpcOptions options{.horizon = knots * kStep,
                     .tick = kStep,
                     .iterations = std::nullopt,
                     .solver = "box_fddp",
                     .solver_options = testing::tight()};
  return testing::with_terminal(problem, options);
}

struct Loop {
  Loop(double limit, int knots, double duration = 20) : problem(regulator(limit)) {
    Mpc mpc(problem, problem->create_trajectory(), options_of(*problem, knots));
    result = run_closed_loop(mpc, {.duration = duration});
  }
  std::shared_ptr<const ShootingProblem> problem;
  ClosedLoopResult result;
};

TEST(DoubleIntegrator, CostsItsValueForAnyHorizon) {
  for (const int knots : {1, 2, 5, 10}) {
    const Loop loop(testing::kFree, knots);
    EXPECT_EQ(loop.result.end, LoopEnd::finished);
    // ½ x₀ᵀ P x₀ with P₁₁ = 1.3317224441130
    EXPECT_NEAR(loop.result.cost, 0.6658612220565547, 1e-9) << knots;
    EXPECT_NEAR(loop.result.ticks[0].cost, 0.6658612220565547, 1e-9) << knots;
  }
}

TEST(DoubleIntegrator, CostsTheBoundedOptimumForAnyHorizon) {
  const double values[] = {.6846654702972, .6959507781838, .7012943894519, .7027180645701,
                           .7027180807405};  // of the first window by number of knots
  for (int knots = 1; knots <= 5; ++knots) {
    const Loop loop(1, knots);
    EXPECT_NEAR(loop.result.ticks[0].cost, values[knots - 1], 1e-9) << knots;
    EXPECT_NEAR(loop.result.cost, .7027180807405, 1e-9) << knots;
    for (const PlantStep& step : loop.result.steps) EXPECT_LE(std::abs(step.u[0]), 1);
  }
}

TEST(DoubleIntegrator, ValueDropsByTheStageCostEachTick) {
  const Loop loop(testing::kFree, 5, 3);
  const Discrete discrete;
  for (std::size_t j = 0; j + 1 < loop.result.ticks.size(); ++j) {
    const PlantStep& step = loop.result.steps[j];
    const Eigen::Map<const Eigen::VectorXd> x(step.x.data(), 2);
    const double stage = 0.5 * x.dot(discrete.Q * x) + 0.5 * discrete.R * step.u[0] * step.u[0];
    EXPECT_NEAR(loop.result.ticks[j].cost - loop.result.ticks[j + 1].cost, stage, 1e-9) << j;
  }
}

// A real-time iteration solves a linear-quadratic problem exactly.
TEST(DoubleIntegrator, IsOptimalWithOneIterationATick) {
  const auto problem = regulator(testing::kFree);
  MpcOptions options = options_of(*problem, 5);
  options.iterations = 1;
  Mpc mpc(problem, problem->create_trajectory(), options);
  EXPECT_NEAR(run_closed_loop(mpc, {.duration = 20}).cost, 0.6658612220565547, 1e-9);
}

TEST(DoubleIntegrator, AcceptsTicksAndDelaysOfWholeKnots) {
  const auto problem = regulator(1);
  MpcOptions options = options_of(*problem, 5);
  options.tick = 0.05;
  EXPECT_THROW(Mpc(problem, problem->create_trajectory(), options), std::invalid_argument);
}

}  // namespace
}  // namespace conddp
