// Points of least violation, compared with dense bounded least squares; slopes, compared with
// differences; and the continuation of a solve after a restoration.
#include <cmath>

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/evaluation/linearization.hpp"
#include "solvers/constraints/violation_slope.hpp"
#include "solvers/strategies/registry.hpp"
#include "solvers/strategies/strategies.hpp"
#include "support/constrained_problems.hpp"

namespace conddp {
namespace {

using testing::with_constraints;

constexpr int kKnots = 20;
constexpr double kStep = 0.1, kLimit = 3;

/// A mass of 1 kg at rest, moved by bounded forces.
ShootingProblem mass() {
  return testing::tracking_problem(double_integrator(1), Integrator::rk4, kKnots, kStep, {0, 0},
                                   {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -kLimit, kLimit);
}

/// Minimum of ‖(p_N, v_N) − goal‖ over the forces, by coordinate descent.
double least_distance(const Eigen::Vector2d& goal) {
  Eigen::MatrixXd map(2, kKnots);
  for (int k = 0; k < kKnots; ++k) map.col(k) << (kKnots - k - 0.5) * kStep * kStep, kStep;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(kKnots);
  Eigen::Vector2d d = -goal;
  for (int sweep = 0; sweep < 20000; ++sweep)
    for (int k = 0; k < kKnots; ++k) {
      const double best = u[k] - map.col(k).dot(d) / map.col(k).squaredNorm();
      const double moved = std::clamp(best, -kLimit, kLimit) - u[k];
      u[k] += moved;
      d += moved * map.col(k);
    }
  return d.norm();
}

/// For convex distances, a share of 0.005 means at most that share above the minimum.
TEST(LeastViolation, MatchesBoundedDenseLeastSquares) {
  const ShootingProblem free = mass();
  for (const Eigen::Vector2d& goal : {Eigen::Vector2d(5, 0), Eigen::Vector2d(2, 8)}) {
    const ShootingProblem problem =
        with_constraints(free, {testing::goal_constraint(free, {goal[0], goal[1]})});
    const double least = least_distance(goal);
    for (const char* solver : {"altro", "proxddp", "ipopt"}) {
      const SolveResult result = solve(problem, solver, {}, problem.create_trajectory());
      ASSERT_EQ(result.status, SolveStatus::infeasible) << solver << ": " << result.message;
      const double found = (result.trajectory.x(kKnots) - goal).norm();
      EXPECT_GE(found, least - 1e-9) << solver;
      EXPECT_LE(found, 1.005 * least) << solver;
      EXPECT_NE(result.message.find("'terminal/goal' by "), std::string::npos) << result.message;
    }
  }
}

TEST(LeastViolation, IsFoundFromAnyTrajectory) {
  const ShootingProblem free = mass();
  const ShootingProblem problem = with_constraints(free, {testing::goal_constraint(free, {5, 0})});
  Trajectory start = testing::constant_controls(problem, -2);
  for (int k = 1; k <= kKnots; ++k) start.x(k) << std::cos(3 * k), 7 - k;
  const SolveResult result = restore_feasibility(problem, {}, start);
  EXPECT_EQ(result.status, SolveStatus::infeasible) << result.message;
  EXPECT_LE(result.residuals.gap, 1e-9);
  EXPECT_LE((result.trajectory.x(kKnots) - Eigen::Vector2d(5, 0)).norm(),
            1.005 * least_distance({5, 0}));
}

TEST(LeastViolation, KeepsGapsClosedUnlessControlsLeadAway) {
  const ShootingProblem free = mass();
  const ShootingProblem problem = with_constraints(free, {testing::goal_constraint(free, {5, 0})});
  Trajectory start = testing::constant_controls(problem, 1);
  const SolveResult closed = restore_feasibility(problem, {}, start);
  for (const IterationRecord& row : closed.log) EXPECT_LE(row.gap, 1e-12) << row.iteration;
  // The states nearly satisfy the constraint, but the controls do not lead there.
  start = testing::constant_controls(problem, 0);
  for (int k = 1; k <= kKnots; ++k) start.x(k) << 5.01 * k / kKnots, 0;
  EXPECT_GT(restore_feasibility(problem, {}, start).log.front().gap, 0.1);
}

TEST(LeastViolation, IsZeroIfConstraintsAreFeasible) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    const Trajectory start = testing::constant_controls(problem, control);
    const SolveResult result = restore_feasibility(problem, {}, start);
    EXPECT_EQ(result.status, SolveStatus::converged) << name << ": " << result.message;
    EXPECT_LE(result.residuals.gap, 1e-9) << name;
    EXPECT_LE(result.log.back().constraint, 0.05 * result.log.front().constraint) << name;
  }
}

/// 20 t at rest that must move 100 m in 10 s: forces of 24 kN, starting from zero.
TEST(LeastViolation, IsNotReportedForDistantFreeControls) {
  constexpr double kMass = 20000;
  Eigen::Matrix2d A;
  A << 1, kStep, 0, 1;
  const ShootingProblem free = testing::tracking_problem(
      linear_system(A, Eigen::Vector2d(0, kStep / kMass), Eigen::Vector2d::Zero()),
      Integrator::discrete, 100, 1, {0, 0}, {{0, 0}, {0, 0}, {1}, {0, 0}});
  const ShootingProblem problem =
      with_constraints(free, {testing::goal_constraint(free, {100, 0})});
  for (const char* solver : {"altro", "proxddp"}) {
    const SolveResult result = solve(problem, solver, {}, problem.create_trajectory());
    EXPECT_NE(result.status, SolveStatus::infeasible) << solver << ": " << result.message;
  }
}

TEST(LeastViolation, IsFoundAtOnceWithoutViolation) {
  const ShootingProblem free = mass();
  const ShootingProblem problem = with_constraints(free, {testing::goal_constraint(free, {0, 0})});
  const SolveResult result = restore_feasibility(problem, {}, problem.create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_EQ(result.iterations, 0);
}

/// ∂‖d‖/∂u by central differences of simulated motions.
TEST(ViolationSlope, MatchesDifferences) {
  const ShootingProblem free = testing::pendulum_swing_up(3);
  const ShootingProblem problem =
      with_constraints(free, {testing::goal_constraint(free, {3, 0}),
                              {.name = "slow",
                               .residual = coordinate_residual(free.manifold(), {1}),
                               .reference = {0},
                               .lower = {-0.2},
                               .upper = {0.1},
                               .first = 5,
                               .last = 12}});
  Evaluator evaluator(problem, 1);
  Linearization linearization(problem);
  const ControlBounds bounds(problem);
  ViolationSlope slope(problem, bounds);
  Trajectory trajectory = testing::constant_controls(problem, 1);
  for (int k = 0; k < problem.knots(); ++k) trajectory.u(k)[0] = 2 * std::sin(1.0 + k);
  const auto violation = [&](Trajectory motion) {
    EXPECT_EQ(evaluator.simulate(motion), -1);
    evaluator.differentiate(motion, linearization);
    return slope.violation(linearization.constraint);
  };
  double largest = 1, sum = 0;
  for (int k = 0; k < problem.knots(); ++k)
    largest = std::max(largest, std::abs(trajectory.u(k)[0]));
  for (int k = 0; k < problem.knots(); ++k) {
    constexpr double kMove = 1e-5;
    Trajectory more = trajectory, less = trajectory;
    more.u(k)[0] += kMove;
    less.u(k)[0] -= kMove;
    const double derivative = (violation(more) - violation(less)) / (2 * kMove);
    const double bound = derivative > 0 ? bounds.lower(k)[0] : bounds.upper(k)[0];
    sum += std::abs(derivative) *
           (std::isfinite(bound) ? std::abs(trajectory.u(k)[0] - bound) : largest);
  }
  EXPECT_EQ(evaluator.simulate(trajectory), -1);
  const double here = violation(trajectory);
  Gaps gaps(problem);
  gaps.set(linearization, true);
  const double share = slope.share(evaluator, trajectory, gaps);
  EXPECT_GT(share, 0.1);
  EXPECT_NEAR(share, sum / here, 1e-6 * share);
}

/// At a minimum of cost plus penalty, the two gradients cancel.
TEST(ViolationSlope, IsIndependentOfTheCost) {
  constexpr double kDear = 1e9;
  const auto share = [](double weight) {
    const ShootingProblem free = testing::tracking_problem(
        double_integrator(1), Integrator::rk4, kKnots, kStep, {0, 0},
        {{1, 0}, {weight, weight}, {weight}, {weight, weight}}, -kLimit, kLimit);
    const ShootingProblem problem =
        with_constraints(free, {testing::goal_constraint(free, {0.01, 0})});
    Evaluator acts(problem, 1);
    Linearization linearization(problem);
    const ControlBounds bounds(problem);
    ViolationSlope slope(problem, bounds);
    Trajectory still = problem.create_trajectory();
    EXPECT_EQ(acts.simulate(still), -1);
    acts.differentiate(still, linearization);
    EXPECT_NEAR(slope.violation(linearization.constraint), 0.01, 1e-12);
    Gaps gaps(problem);
    gaps.set(linearization, true);
    return slope.share(acts, still, gaps);
  };
  const double cheap = share(0);
  EXPECT_GT(cheap, 1);
  EXPECT_NEAR(share(kDear), cheap, 1e-6 * cheap);
}

/// Each control ranges up to the magnitude of the largest one, even if that is the first or last.
TEST(ViolationSlope, FreeControlsRangeUpToTheLargestOne) {
  const ShootingProblem free =
      testing::tracking_problem(double_integrator(1), Integrator::rk4, 3, kStep, {0, 0},
                                {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -testing::kFree, testing::kFree);
  const ShootingProblem problem = with_constraints(free, {testing::goal_constraint(free, {3, 4})});
  const ControlBounds bounds(problem);
  ViolationSlope slope(problem, bounds);
  EXPECT_EQ(slope.violation(Eigen::Vector2d(-3, -4)), 5);
  const Eigen::Vector3d gradient(1, -2, 0.5);
  for (int largest = 0; largest < 3; ++largest) {
    Trajectory trajectory = testing::constant_controls(problem, 0.1);
    EXPECT_DOUBLE_EQ(slope.share(gradient, trajectory), 3.5 * 1 / 25) << "at least 1";
    trajectory.u(largest)[0] = -6;
    EXPECT_DOUBLE_EQ(slope.share(gradient, trajectory), 3.5 * 6 / 25) << largest;
  }
}

/// A solver that fails at once and, after the restoration, works normally.
TEST(SolveWithRestoration, ContinuesFromTheRestoredPoint) {
  const auto cases = testing::published_cases();
  const auto& [name, problem, control, cost] = cases[0];
  const Trajectory guess = testing::constant_controls(problem, control);
  std::vector<double> penalties;
  std::vector<Trajectory> starts;
  const auto solve = [&](const SolverOptions& options, const Trajectory& start) {
    penalties.push_back(options.augmented_lagrangian.initial_penalty);
    starts.push_back(start);
    SolverOptions own = options;
    if (starts.size() == 1) own.max_iterations = 3;
    SolveResult result = find_solver("altro")->run(problem, own, start);
    if (starts.size() == 1) result.status = SolveStatus::infeasible;
    return result;
  };
  const SolveResult result = solve_with_restoration(problem, {}, guess, solve);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.cost, cost, 1e-2 * cost);
  ASSERT_EQ(starts.size(), 2U);
  EXPECT_GE(penalties[1], penalties[0]);
  EXPECT_TRUE(result.message.starts_with("stalled at iteration 3, restoration of feasibility; "))
      << result.message;
  int restored = 0;
  for (std::size_t i = 0; i < result.log.size(); ++i) {
    restored += result.log[i].restoration;
    if (i == 0) continue;
    EXPECT_GE(result.log[i].iteration, result.log[i - 1].iteration);
    EXPECT_GE(result.log[i].time_s, result.log[i - 1].time_s);
  }
  EXPECT_GT(restored, 0);
  EXPECT_EQ(result.log.back().iteration, result.iterations);
}

TEST(SolveWithRestoration, ReportsInfeasibleOnlyAfterRestoration) {
  const ShootingProblem problem = mass();  // without constraints, restoration has no task
  const auto solve = [&](const SolverOptions& options, const Trajectory& start) {
    SolveResult result = find_solver("ipopt")->run(problem, options, start);
    result.status = SolveStatus::infeasible;
    return result;
  };
  const SolveResult result =
      solve_with_restoration(problem, {}, problem.create_trajectory(), solve);
  EXPECT_EQ(result.status, SolveStatus::line_search_failed);
  EXPECT_NE(result.message.find("has not been decided"), std::string::npos) << result.message;
}

TEST(SolveWithRestoration, SharesItsLimits) {
  const ShootingProblem free = mass();
  const ShootingProblem problem = with_constraints(free, {testing::goal_constraint(free, {5, 0})});
  const Trajectory guess = problem.create_trajectory();
  const SolveResult whole = solve(problem, "altro", {}, guess);
  ASSERT_EQ(whole.status, SolveStatus::infeasible);
  ASSERT_GT(whole.log.back().restoration, 0);
  int before = 0;
  for (const IterationRecord& row : whole.log)
    if (row.restoration == 0) before = row.iteration;
  const SolveResult none = solve(problem, "altro", {.max_iterations = before}, guess);
  EXPECT_NE(none.status, SolveStatus::infeasible) << none.message;
  EXPECT_LE(none.iterations, before);
}

}  // namespace
}  // namespace conddp
