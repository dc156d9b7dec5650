#include "solvers/constraints/horizon_constraints.hpp"

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/conic_problems.hpp"
#include "support/small_problems.hpp"

namespace conddp::testing {
namespace {

/// A conic problem linearised at zero, and steps from there.
struct Horizon {
  Horizon()
      : conic(1, middle_size()),
        augmentation(*conic.problem),
        linearization(*conic.problem),
        constraints(*conic.problem) {
    const ShootingProblem& problem = *conic.problem;
    augmentation.penalty.setOnes();
    Evaluator(problem).differentiate(problem.create_trajectory(), linearization, &augmentation);
    for (int k = 0; k <= problem.knots(); ++k)
      z.push_back(Eigen::VectorXd::Zero(problem.knot(k).model->nz()));
    constraints.start(linearization, &augmentation);
  }

  ConicLinearQuadratic conic;
  Augmentation augmentation;
  Linearization linearization;
  HorizonConstraints constraints;
  std::vector<Eigen::VectorXd> z;
  std::optional<int> last;
};

// Sweeps begin again where a model of rows changed last, so that node has to be told.
TEST(HorizonConstraints, TellTheLastNodeWhoseRowsCrossed) {
  Horizon horizon;
  auto& [conic, augmentation, linearization, constraints, z, last] = horizon;

  EXPECT_EQ(constraints.revise(z, 0, linearization, last), 0);
  EXPECT_FALSE(last.has_value());
  z[3].setConstant(100);
  z[7].setConstant(-100);
  EXPECT_GE(constraints.revise(z, 0, linearization, last), 2);
  EXPECT_EQ(last, 7);
  last.reset();
  EXPECT_EQ(constraints.revise(z, 0, linearization, last), 0);
  EXPECT_FALSE(last.has_value());
  z[7].setZero();
  EXPECT_GE(constraints.revise(z, 0, linearization, last), 1);
  EXPECT_EQ(last, 7);
}

TEST(HorizonConstraints, LeaveAModelThatIsOffByLessThanAllowed) {
  Horizon horizon;
  auto& [conic, augmentation, linearization, constraints, z, last] = horizon;
  z[3].setConstant(100);
  const Eigen::VectorXd gradient = linearization.knots[3].gradient;
  EXPECT_EQ(constraints.revise(z, 1e12, linearization, last), 0);
  EXPECT_EQ(linearization.knots[3].gradient, gradient);
  EXPECT_GE(constraints.revise(z, 1e-12, linearization, last), 1);
  EXPECT_NE(linearization.knots[3].gradient, gradient);
}

// The next iterate's model begins where the last step settled, with its multipliers, once.
TEST(HorizonConstraints, ExpectTheRowsOfTheStepBefore) {
  Horizon horizon;
  auto& [conic, augmentation, linearization, constraints, z, last] = horizon;
  z[3].setConstant(100);
  ASSERT_GE(constraints.revise(z, 0, linearization, last), 1);
  const Eigen::VectorXd settled = linearization.knots[3].gradient;
  ASSERT_EQ(constraints.revise(z, 0, linearization, last), 0);
  constraints.settle();
  ASSERT_TRUE(constraints.restore(linearization));
  const Eigen::VectorXd own = linearization.knots[3].gradient;

  constraints.start(linearization, &augmentation);
  constraints.expect(linearization);
  EXPECT_LT((linearization.knots[3].gradient - settled).norm(), 1e-9 * settled.norm());
  EXPECT_EQ(constraints.revise(z, 0, linearization, last), 0);
  constraints.restore(linearization);
  EXPECT_EQ(linearization.knots[3].gradient, own);
  constraints.start(linearization, &augmentation);
  constraints.expect(linearization);
  EXPECT_EQ(linearization.knots[3].gradient, own) << "what was expected once is past";
}

/// A mass that is sent to 1 and back, beyond walls and a speed which cost the square of how far.
ShootingProblem beyond_walls(double weight) {
  Eigen::MatrixXd A(2, 2), B(2, 1);
  A << 1, 0.1, 0, 1;
  B << 0.005, 0.1;
  const std::shared_ptr<const System> system = linear_system(A, B, Eigen::VectorXd::Zero(2));
  const TrackingCost cost{{1, 0}, {1, 0.01}, {1e-3}, {10, 10}, false};
  constexpr int kKnots = 40;
  Phase phase = tracking_phase(system, Integrator::discrete, kKnots, 1, cost, -3, 3);
  auto model = std::make_shared<KnotModel>(*phase.model);
  constexpr double kNone = kFree;
  model->add_cost("walls", state_residual(model->manifold()),
                  {.kind = ActivationKind::quadratic_barrier,
                   .weights = {1, 0.5},
                   .lower = {-kNone, -0.4},
                   .upper = {0.7, 0.4}});
  std::vector<double> parameters;
  const int before = phase.model->parameter_count();
  for (int k = 0; k < kKnots; ++k) {
    const auto first = phase.parameters.begin() + k * before;
    parameters.insert(parameters.end(), first, first + before);
    parameters.insert(parameters.end(), {0, 0, weight});
  }
  phase.model = std::move(model);
  phase.parameters = std::move(parameters);
  return ShootingProblem({0, 0}, {std::move(phase)}, terminal_phase(system, cost));
}

// The minimum of a piecewise quadratic problem is found in the model: sweeps, but no iterations.
TEST(HorizonConstraints, BarriersThatAStepCrossesArePartOfItsModel) {
  for (const double weight : {1.0, 100.0, 1e4}) {
    const ShootingProblem problem = beyond_walls(weight);
    const Trajectory guess = problem.create_trajectory();
    for (const char* solver : {"box_ddp", "box_fddp"}) {
      const SolveResult result = solve(problem, solver, {}, guess);
      EXPECT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
      EXPECT_LE(result.iterations, 2) << solver << ' ' << weight;
      SolverOptions stages;
      stages.box_qp.horizon_sweeps = 0;  // each knot by itself, at the iterate's side of each wall
      const SolveResult slow = solve(problem, solver, stages, guess);
      EXPECT_EQ(slow.status, SolveStatus::converged) << solver << ": " << slow.message;
      EXPECT_GT(slow.iterations, 5) << solver;
      EXPECT_NEAR(result.cost, slow.cost, 1e-9 * slow.cost) << solver;
      double furthest = 0;
      for (int k = 0; k <= problem.knots(); ++k)
        furthest = std::max(furthest, result.trajectory.x(k)[0]);
      EXPECT_GT(furthest, 0.7) << "the wall is met";
    }
  }
}

// Written gains are those of the iterate's own costs, also where the solve ends on the way.
TEST(HorizonConstraints, GainsOfAnAnswerAreThoseOfItsOwnSideOfEachWall) {
  const ShootingProblem problem = beyond_walls(100);
  SolverOptions options;
  options.max_iterations = 0;
  const SolveResult start = solve(problem, "box_ddp", options, problem.create_trajectory());
  const SolveResult without =
      solve(beyond_walls(0), "box_ddp", options, problem.create_trajectory());
  for (int k = 0; k < problem.knots(); ++k)
    EXPECT_EQ(start.feedback.K[k], without.feedback.K[k]) << "at rest no wall is crossed";
}

}  // namespace
}  // namespace conddp::testing
