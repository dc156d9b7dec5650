// Newton steps on active constraints, compared with dense quadratic programs.
#include "solvers/constraints/projected_newton.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/iterate/hessian_switch.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_convex.hpp"
#include "support/plain_sqp.hpp"

namespace conddp::testing {
namespace {

constexpr double kLimit = 4;

/// Newton's method at points of a PlainSqp whose solution has the speed and one control at their
/// limits.
struct NewtonCase {
  NewtonCase()
      : sqp{.plain = {.limit = kLimit}},
        problem(sqp.problem()),
        evaluator(problem),
        solution(sqp.solution(sqp.simulated(2.2), problem)) {}

  /// The solution with perturbed states and controls.
  PlainSqp::Point near(double size) const {
    PlainSqp::Point p = solution;
    RandomNumbers random(3);
    for (int k = 0; k < sqp.plain.knots; ++k) {
      p.x[k + 1] += size * Eigen::Vector2d(random.uniform(-1, 1), random.uniform(-1, 1));
      p.u[k] = std::clamp(p.u[k] + size * random.uniform(-1, 1), -kLimit, kLimit);
    }
    p.multipliers += size * Eigen::Vector2d(0.5, -1);
    return p;
  }
  void start(ProjectedNewton& newton, const PlainSqp::Point& p) const {
    newton.start(p.trajectory(problem), sqp.rows(p.multipliers), Eigen::VectorXd::Constant(6, 10),
                 Feedback(problem));
  }

  PlainSqp sqp;
  ShootingProblem problem;
  Evaluator evaluator;
  PlainSqp::Point solution;
};

TEST(ProjectedNewton, TestProblemHasActiveRowsAndControls) {
  const NewtonCase at;
  EXPECT_GT(at.solution.multipliers[0], 0.1);
  EXPECT_EQ((at.solution.u.array().abs() > kLimit - 1e-12).count(), 1);
  const PlainSqp::Point again = at.sqp.step(at.solution, at.problem);
  EXPECT_LT(again.distance(at.solution.trajectory(at.problem)), 1e-12);
}

TEST(ProjectedNewton, FailedStepsLeaveTheIterate) {
  NewtonCase at;
  ProjectedNewton newton(at.problem, at.evaluator);
  at.start(newton, at.near(0.2));
  const Eigen::VectorXd multipliers = newton.multipliers();
  const double before = newton.norms().largest(), violation = newton.norms().violation.value;
  EXPECT_FALSE(newton.step(0));
  EXPECT_EQ(newton.multipliers(), multipliers);
  EXPECT_EQ(newton.norms().violation.value, violation);
  EXPECT_NEAR(newton.norms().largest(), before, 1e-12 * before);
}

TEST(ProjectedNewton, StepMatchesDenseExactQuadraticProgram) {
  for (const double size : {0.2, 0.05, 1e-3}) {
    SCOPED_TRACE(size);
    NewtonCase at;
    ProjectedNewton newton(at.problem, at.evaluator);
    PlainSqp::Point from = at.near(size);
    at.start(newton, from);
    // Inactive rows have zero multipliers.
    from.multipliers = {newton.multipliers()[3], newton.multipliers()[5]};
    const PlainSqp::Point expected = at.sqp.step(from, at.problem);
    ASSERT_TRUE(newton.step(1e3));
    EXPECT_EQ(newton.step_length(), 1);
    EXPECT_LT(expected.distance(newton.trajectory()), 1e-9);
    EXPECT_LT((newton.multipliers() - at.sqp.rows(expected.multipliers)).norm(), 1e-8);
    EXPECT_EQ(newton.active_rows(), 3);
    const PlainSqp::Point other = at.sqp.step(from, at.problem, false);
    EXPECT_GT(other.distance(newton.trajectory()), 1e-2 * size) << "of the costs' Hessian";
  }
}

TEST(ProjectedNewton, StepsConvergeQuadratically) {
  NewtonCase at;
  ProjectedNewton newton(at.problem, at.evaluator);
  at.start(newton, at.near(0.2));
  double error = at.solution.distance(newton.trajectory());
  EXPECT_GT(error, 0.1);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(newton.step());
    const double next = at.solution.distance(newton.trajectory());
    EXPECT_LT(next, std::max(5 * error * error, 1e-10)) << i;
    error = next;
  }
  EXPECT_LT(error, 1e-9);
  EXPECT_LT((newton.multipliers() - at.sqp.rows(at.solution.multipliers)).norm(), 1e-8);
}

/// A linear system with quadratic costs that passes a disc with its first two coordinates: only the
/// rows have curvature that Gauss-Newton omits.
struct DiscCase {
  explicit DiscCase(int dimension)
      : problem(make(dimension)),
        evaluator(problem),
        solution(solve(problem, "altro", tight(), constant_controls(problem, 0))) {}

  static SolverOptions tight() {
    SolverOptions options;
    options.tolerances.stationarity = options.tolerances.constraint = 1e-11;
    return options;
  }
  static ShootingProblem make(int n) {
    const auto pair = [n](double x, double y, double vx, double vy) {
      std::vector<double> state(2 * n, 0.0);
      state[0] = x, state[1] = y, state[n] = vx, state[n + 1] = vy;
      return state;
    };
    const auto weights = [n](double position, double velocity) {
      std::vector<double> state(n, position);
      state.resize(2 * n, velocity);
      return state;
    };
    const ShootingProblem free = tracking_problem(
        double_integrator(n), Integrator::semi_implicit_euler, 8, 0.25, pair(-1, 0.3, 0, 0),
        {pair(1, -0.1, 0, 0), weights(1, 0.1), std::vector<double>(n, 0.1), weights(20, 5)});
    return with_constraints(free, {{.name = "disc",
                                    .residual = coordinate_residual(free.manifold(), {0, 1}),
                                    .kind = ConstraintKind::norm,
                                    .reference = {0, 0},
                                    .lower = {0.5},
                                    .upper = {kFree},
                                    .first = 1,
                                    .last = 8}});
  }
  /// At the solution's multipliers, with states and controls perturbed by `off`.
  void start(ProjectedNewton& newton, double off) const {
    Trajectory from = solution.trajectory;
    RandomNumbers random(5);
    for (int k = 0; k < problem.knots(); ++k) {
      for (double& u : from.u(k)) u += off * random.uniform(-1, 1);
      for (double& x : from.x(k + 1)) x += off * random.uniform(-1, 1);
    }
    newton.start(from, solution.constraint_multipliers,
                 Eigen::VectorXd::Constant(problem.constraint_rows(), 10), Feedback(problem));
  }
  double error(const ProjectedNewton& newton) const {
    return (controls_of(newton.trajectory()) - controls_of(solution.trajectory))
        .lpNorm<Eigen::Infinity>();
  }

  ShootingProblem problem;
  Evaluator evaluator;
  SolveResult solution;
};

TEST(ProjectedNewton, StepsConvergeQuadraticallyOnCurvedRows) {
  DiscCase at(2);
  ASSERT_EQ(at.solution.status, SolveStatus::converged) << at.solution.message;
  ASSERT_GT(at.solution.constraint_multipliers.cwiseAbs().maxCoeff(), 0.1);
  ProjectedNewton newton(at.problem, at.evaluator);
  at.start(newton, 0.05);
  // Exact multipliers: the error of the first step is quadratic too.
  for (const double largest : {2e-2, 1e-4, 1e-9}) {
    ASSERT_TRUE(newton.step(1e3)) << largest;
    EXPECT_LT(at.error(newton), largest);
  }
  EXPECT_EQ(newton.exact_hessians(), 3);
}

TEST(ProjectedNewton, KeepsCostlyHessiansWhileStepsGainADecade) {
  DiscCase at(10);
  ASSERT_TRUE(exact_hessians_are_dear(at.problem));
  ASSERT_EQ(at.solution.status, SolveStatus::converged) << at.solution.message;
  ProjectedNewton newton(at.problem, at.evaluator);
  at.start(newton, 0.05);
  ASSERT_GT(at.solution.constraint_multipliers.cwiseAbs().maxCoeff(), 0.1);
  int steps = 0, expected = 0;
  bool keeps = false;
  while (newton.norms().largest() > 1e-11) {
    const double was = newton.norms().largest();
    ASSERT_TRUE(newton.step());
    ++steps;
    expected += !keeps;
    EXPECT_EQ(newton.exact_hessians(), expected);
    keeps = newton.step_length() == 1 && newton.norms().largest() <= 0.1 * was;
    ASSERT_LT(expected, 4);
  }
  EXPECT_TRUE(keeps);
  EXPECT_GT(steps, expected);
  EXPECT_LT(at.error(newton), 1e-8);
  // If the kept Hessian yields no step, a new one is computed.
  EXPECT_FALSE(newton.step(1e-30));
  EXPECT_EQ(newton.exact_hessians(), expected + 1);
}

TEST(ProjectedNewton, NormsMatchTheIterate) {
  NewtonCase at;
  ProjectedNewton newton(at.problem, at.evaluator);
  PlainSqp::Point p = at.near(0.1);
  p.x[3][1] = 1.05;
  p.multipliers[0] = 0.5;
  at.start(newton, p);
  const auto lambda = at.sqp.costates(p);
  const PlainPendulum& plain = at.sqp.plain;
  double stationarity = 0, gap = 0, cost = plain.end_cost<double>(p.x.back());
  int stationarity_knot = -1, gap_knot = -1;
  for (int k = 0; k < plain.knots; ++k) {
    const double gradient =
        plain.stage_gradient(p.x[k], p.u[k])[2] + plain.jacobian(p.x[k]).col(2).dot(lambda[k + 1]);
    const bool held = std::abs(p.u[k]) == kLimit && gradient * p.u[k] < 0;
    if (!held && std::abs(gradient) > stationarity) {
      stationarity = std::abs(gradient);
      stationarity_knot = k;
    }
    const double here = (plain.next<double>(p.x[k], p.u[k]) - p.x[k + 1]).lpNorm<Eigen::Infinity>();
    if (here > gap) {
      gap = here;
      gap_knot = k;
    }
    cost += plain.stage_cost<double>(p.x[k], p.u[k]);
  }
  const KktNorms& norms = newton.norms();
  EXPECT_NEAR(norms.stationarity.value, stationarity, 1e-12);
  EXPECT_EQ(norms.stationarity.knot, stationarity_knot);
  EXPECT_NEAR(norms.gap.value, gap, 1e-14);
  EXPECT_EQ(norms.gap.knot, gap_knot);
  const double end_off = std::abs(p.x.back()[0] - 0.8);
  EXPECT_NEAR(norms.violation.value, std::max(0.05, end_off), 1e-14);
  EXPECT_EQ(norms.violation.knot, end_off > 0.05 ? 5 : 3);
  EXPECT_NEAR(norms.complementarity, 0, 1e-14);
  EXPECT_NEAR(newton.cost(), cost, 1e-13);
  EXPECT_EQ(norms.largest(),
            std::max({norms.stationarity.value, norms.gap.value, norms.violation.value}));
  IterationRecord row;
  newton.describe(row);
  EXPECT_EQ(row.stationarity, norms.stationarity.value);
  EXPECT_EQ(row.gap, norms.gap.value);
  EXPECT_EQ(row.constraint, norms.violation.value);
  EXPECT_EQ(row.cost, newton.cost());
  EXPECT_EQ(row.step, 0);

  p.multipliers[0] = 0.5;
  p.x[3][1] = 0.99;  // 0.99 + 0.5/10 is beyond: 0.5 · 0.01
  at.start(newton, p);
  EXPECT_NEAR(newton.norms().complementarity, 0.005, 1e-14);
}

// The active set is that of the solution, where the exact Hessian has negative curvature.
TEST(ProjectedNewton, NonConvexHessiansFallBackToCosts) {
  NewtonCase at;
  PlainSqp::Point p = at.near(1e-3);
  p.multipliers[1] = -1000;
  const DenseHorizon exact = at.sqp.model(p, at.problem, true);
  Eigen::Index held = 0;
  at.solution.u.cwiseAbs().maxCoeff(&held);
  Eigen::MatrixXd kept(3, exact.S.cols());
  kept << exact.S.row(exact.offset[3] + 1), exact.S.row(exact.offset[5]),
      exact.S.row(exact.offset[held] + 2);
  const Eigen::MatrixXd Z = kept.fullPivLu().kernel();
  const Eigen::MatrixXd reduced = Z.transpose() * exact.S.transpose() * exact.H * exact.S * Z;
  ASSERT_LT(reduced.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-3);
  ProjectedNewton newton(at.problem, at.evaluator);
  at.start(newton, p);
  ASSERT_TRUE(newton.step(1e6));
  EXPECT_EQ(newton.active_rows(), 3);
  EXPECT_LT(at.sqp.step(p, at.problem, false).distance(newton.trajectory()), 1e-9);
}

TEST(ProjectedNewton, KeepsIterateIfNoStepLowersNorms) {
  NewtonCase at;
  ProjectedNewton newton(at.problem, at.evaluator);
  at.start(newton, at.near(0.05));
  const Trajectory from = newton.trajectory();
  const Eigen::VectorXd multipliers = newton.multipliers();
  EXPECT_FALSE(newton.step(1e-9)) << "no step makes that much";
  EXPECT_EQ(newton.step_length(), 0);
  EXPECT_EQ(newton.multipliers(), multipliers);
  for (int k = 0; k <= from.knots(); ++k) EXPECT_EQ(newton.trajectory().x(k), from.x(k)) << k;
  for (int k = 0; k < from.knots(); ++k) EXPECT_EQ(newton.trajectory().u(k), from.u(k)) << k;
}

/// Stores multipliers and penalties, and accepts others.
struct KeptMultipliers : OuterStrategy {
  explicit KeptMultipliers(const ShootingProblem& problem) : given(problem) {
    given.penalty.setConstant(10);
  }
  const Augmentation* augmentation() const override { return &given; }
  const Eigen::VectorXd* multipliers() const override { return &known; }
  void adopt(const Eigen::VectorXd& multipliers) override { known = multipliers; }

  Augmentation given;
  Eigen::VectorXd known;
};

/// A solve that has reached a point of a NewtonCase.
struct PolishedSolve {
  explicit PolishedSolve(double size, int max_iterations = 100)
      : options{.max_iterations = max_iterations},
        bounds(at.problem),
        record(at.problem, options, true),
        iterate(at.problem, bounds, at.evaluator, recipe, options, record),
        outer(at.problem),
        polish(at.problem, at.evaluator, options) {
    const PlainSqp::Point p = at.near(size);
    iterate.trajectory = p.trajectory(at.problem);
    outer.known = at.sqp.rows(p.multipliers);
    record.begin();
    polish.reset();
    record.row.iteration = 7;
    record.row.stationarity = size;
    record.row.gap = size / 2;
    record.row.active_rows = 99;
  }
  bool run() { return polish.run(iterate, Feedback(at.problem), outer, record); }

  NewtonCase at;
  SolverOptions options;
  DdpRecipe recipe;
  ControlBounds bounds;
  SolveRecord record;
  Iterate iterate;
  KeptMultipliers outer;
  NewtonPolish polish;
};

TEST(NewtonPolish, EndsSolvesAtSolutionWithMultipliers) {
  PolishedSolve solve(1e-3);
  const Trajectory start = solve.iterate.trajectory;
  solve.iterate.linearized = solve.iterate.differentiated = true;
  ASSERT_TRUE(solve.polish.due(solve.record.row));
  ASSERT_TRUE(solve.run());
  EXPECT_LT(solve.at.solution.distance(solve.iterate.trajectory), 1e-10);
  EXPECT_EQ(solve.iterate.before.x(2), start.x(2));
  EXPECT_FALSE(solve.iterate.linearized || solve.iterate.differentiated);
  EXPECT_LT((solve.outer.known - solve.at.sqp.rows(solve.at.solution.multipliers)).norm(), 1e-8);
  const int steps = solve.record.row.newton;
  EXPECT_GE(steps, 2);
  EXPECT_LE(steps, 3);
  EXPECT_EQ(solve.record.row.iteration, 7 + steps);
  EXPECT_EQ(static_cast<int>(solve.record.result.log.size()), steps);
  EXPECT_FALSE(solve.record.log_is_stale);
  EXPECT_LE(solve.record.row.stationarity, 1e-9);
}

TEST(NewtonPolish, LeavesFailedIteratesAndWaitsUntilMuchNearer) {
  PolishedSolve solve(1e-3, 8);  // one step is left
  const Trajectory start = solve.iterate.trajectory;
  const Eigen::VectorXd multipliers = solve.outer.known;
  EXPECT_FALSE(solve.run());
  EXPECT_EQ(solve.iterate.trajectory.x(2), start.x(2));
  EXPECT_EQ(solve.outer.known, multipliers);
  EXPECT_EQ(solve.record.row.iteration, 8);
  EXPECT_EQ(solve.record.row.newton, 1);
  EXPECT_EQ(solve.record.row.stationarity, 1e-3);
  EXPECT_EQ(solve.record.row.active_rows, 99);
  EXPECT_EQ(solve.record.result.log.size(), 1u);
  EXPECT_EQ(solve.record.result.log[0].active_rows, 3);
  EXPECT_TRUE(solve.record.log_is_stale);

  IterationRecord row;
  row.gap = 1.01e-4;
  EXPECT_FALSE(solve.polish.due(row));
  row.gap = 0.99e-4;
  EXPECT_TRUE(solve.polish.due(row));
  solve.polish.reset();
  for (double IterationRecord::*norm :
       {&IterationRecord::stationarity, &IterationRecord::gap, &IterationRecord::constraint}) {
    IterationRecord far, near;
    far.*norm = 3.1e-3;
    near.*norm = 2.9e-3;
    EXPECT_FALSE(solve.polish.due(far));
    EXPECT_TRUE(solve.polish.due(near));
  }
}

}  // namespace
}  // namespace conddp::testing
