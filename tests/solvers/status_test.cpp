#include "solvers/common/status.hpp"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/common/feasible.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/ddp/ddp_solver.hpp"
#include "solvers/ddp/family.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/sizes.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

using testing::constant_controls;

/// True if every number of a result's trajectory, gains, and costates is finite.
bool finite(const SolveResult& result) {
  bool all = result.costates.allFinite();
  for (int k = 0; k <= result.trajectory.knots(); ++k) {
    all = all && result.trajectory.x(k).allFinite();
    if (k == result.trajectory.knots()) break;
    all = all && result.trajectory.u(k).allFinite() && result.feedback.k[k].allFinite() &&
          result.feedback.K[k].allFinite();
  }
  return all;
}

TEST(Status, NamesAreDistinctAndOnlyFailuresNegative) {
  std::set<std::string_view> names;
  for (int i = 1; i >= -7; --i) {
    names.insert(to_string(static_cast<SolveStatus>(i)));
    EXPECT_EQ(is_success(static_cast<SolveStatus>(i)), i >= 0);
  }
  EXPECT_EQ(names.size(), 9u);
  EXPECT_EQ(names.count("unknown"), 0u);
}

TEST(Status, FeasibleIgnoresStationarityOnly) {
  const SolverOptions::Tolerances tolerances;
  Residuals at{.stationarity = 1, .gap = 0, .constraint = 0};
  EXPECT_TRUE(is_feasible(at, tolerances));
  for (double* residual : {&at.gap, &at.constraint, &at.complementarity})
    for (const double bad : {1.0, std::nan("")}) {
      *residual = bad;
      EXPECT_FALSE(is_feasible(at, tolerances));
      *residual = 0;
    }
}

TEST(Status, ConvergedMeansAllResidualsAreUnderTolerance) {
  const ShootingProblem problem = testing::unicycle_parking(1);
  for (const char* name : {"box_ddp", "box_fddp"}) {
    const SolveResult result = solve(problem, name, {}, constant_controls(problem, 0.01));
    EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
    EXPECT_LE(result.residuals.stationarity, 1e-6);
    EXPECT_LE(result.residuals.gap, 1e-9);
    EXPECT_EQ(result.residuals.constraint, 0);
    EXPECT_FALSE(result.message.starts_with("at the end")) << "said of those that ended otherwise";
  }
}

TEST(Status, MaxIterations) {
  const ShootingProblem problem = testing::pendulum_swing_up();
  for (const SolverInfo& solver : solvers()) {
    const SolveResult result =
        solve(problem, solver, {.max_iterations = 3}, constant_controls(problem, 0.1));
    EXPECT_EQ(result.status, SolveStatus::max_iterations) << solver.name;
    EXPECT_EQ(result.iterations, 3);
    EXPECT_GE(result.log.size(), 4u);
    EXPECT_LE(result.log.size(), solver.name == "ipopt" ? 5u : 4u) << "back to the best iterate";
    EXPECT_TRUE(finite(result));
    EXPECT_NE(result.message.find("stationarity"), std::string::npos) << result.message;
    EXPECT_EQ(result.log.back().cost, result.cost);
  }
}

// x⁺ = x + u from 1 with weights of 1e-8: at rest, gradients are far below tolerance although most
// of the cost could still be gained.
TEST(Status, SmallGradientWithMuchGainIsNotConverged) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const ShootingProblem problem = testing::tracking_problem(
      linear_system(one, one, Eigen::VectorXd::Zero(1)), Integrator::discrete, 5, 1, {1},
      {{0}, {1e-8}, {1e-8}, {1e-8}, false});
  for (const char* name : {"ilqr", "ilqr_clip", "ddp", "box_ddp", "fddp", "box_fddp"})
    for (const int most : {0, 5}) {
      SolverOptions options;
      options.max_iterations = most;
      DdpSolver solver(problem, find_ddp_member(name)->recipe, options);
      const SolveResult result = solver.solve(constant_controls(problem, 0));
      EXPECT_LT(result.residuals.stationarity, 1e-7) << name;
      EXPECT_EQ(result.status, most == 0 ? SolveStatus::max_iterations : SolveStatus::converged)
          << name << ": " << result.message;
    }
}

TEST(Status, CostSettledEndsFeasibleSolvesWithFlatCost) {
  const ShootingProblem problem = testing::cartpole_swing_up();
  constexpr double kShare = 1e-3;
  for (const SolverInfo& solver : solvers()) {
    // Interior points without restoration do not swing this pole up.
    if (unsupported(solver, problem) || solver.name == "ipddp") continue;
    SCOPED_TRACE(solver.name);
    SolverOptions options;
    options.tolerances.stationarity = 1e-7;
    const Trajectory guess = constant_controls(problem, 0.1);
    const SolveResult best = solve(problem, solver, options, guess);
    options.tolerances.cost_decrease = kShare;
    const SolveResult result = solve(problem, solver, options, guess);
    ASSERT_EQ(best.status, SolveStatus::converged) << best.message;
    if (result.status == SolveStatus::converged) continue;  // Newton's last steps came first
    EXPECT_EQ(result.status, SolveStatus::cost_settled) << result.message;
    EXPECT_LT(result.iterations, best.iterations);
    EXPECT_LE(result.residuals.gap, options.tolerances.gap);
    EXPECT_LE(result.residuals.constraint, options.tolerances.constraint);
    EXPECT_GT(result.residuals.stationarity, options.tolerances.stationarity);
    for (std::size_t i = result.log.size() - 3; i < result.log.size(); ++i)
      EXPECT_NEAR(result.log[i].cost, result.log[i - 1].cost, kShare * result.log[i].cost);
  }
}

TEST(Status, CostSettledNeedsSatisfiedConstraints) {
  for (const auto& [of, problem, control, cost] : testing::published_cases())
    for (const char* name : {"altro", "proxddp"}) {
      SCOPED_TRACE(fmt::format("{} by {}", of, name));
      SolverOptions options;
      options.tolerances.stationarity = 1e-10;
      options.tolerances.cost_decrease = 0.01;
      const SolveResult result = solve(problem, name, options, constant_controls(problem, control));
      EXPECT_TRUE(is_success(result.status)) << result.message;
      EXPECT_LE(result.residuals.constraint, options.tolerances.constraint);
      EXPECT_LE(result.residuals.gap, options.tolerances.gap);
      EXPECT_LE(result.residuals.complementarity, options.tolerances.complementarity);
    }
}

TEST(Status, TimeLimit) {
  const ShootingProblem problem = testing::pendulum_swing_up();
  const SolveResult result =
      solve(problem, "ilqr", {.max_time_s = 0}, constant_controls(problem, 0.1));
  EXPECT_EQ(result.status, SolveStatus::time_limit);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_TRUE(finite(result));
  ASSERT_TRUE(result.feedback_regularization);
}

TEST(Status, InterruptedKeepsTheIterateReached) {
  const ShootingProblem problem = testing::pendulum_swing_up();
  SolverOptions options;
  int rows = 0;
  options.on_iteration = [&rows](const IterationRecord&) { ++rows; };
  options.interrupted = [&rows] { return rows > 4; };
  const SolveResult result = solve(problem, "fddp", options, constant_controls(problem, 0.1));
  EXPECT_EQ(result.status, SolveStatus::interrupted);
  EXPECT_EQ(result.iterations, 4);
  EXPECT_TRUE(finite(result));
  EXPECT_LT(result.cost, result.log[0].cost);
}

TEST(Status, LongIterationsStopMidwayWithACompleteIterate) {
  // More knots than lanes between two checkpoints: derivatives, sweeps, and rollouts each pass
  // several.
  const ShootingProblem problem =
      testing::tracking_problem(pendulum({}), Integrator::rk4, 20000, 1e-3, {0, 0},
                                {{M_PI, 0}, {1e-3, 1e-3}, {1e-3}, {10, 10}}, -3, 3);
  std::set<int> ended_at;
  for (const char* name : {"box_fddp", "altro"})
    for (const int last_poll : {2, 11, 30, 64, 150, 250}) {
      SolverOptions options;
      int polls = 0;
      options.interrupted = [&] { return ++polls >= last_poll; };
      const SolveResult result = solve(problem, name, options, constant_controls(problem, 0.1));
      SCOPED_TRACE(fmt::format("{}, poll {}", name, last_poll));
      EXPECT_EQ(result.status, SolveStatus::interrupted);
      EXPECT_EQ(polls, last_poll) << "nothing goes on after it";
      EXPECT_TRUE(finite(result));
      EXPECT_EQ(result.log.back().cost, result.cost);
      EXPECT_EQ(result.log.back().stationarity, result.residuals.stationarity);
      Evaluation evaluation(problem);
      Evaluator(problem).evaluate(result.trajectory, evaluation);
      EXPECT_NEAR(evaluation.cost.sum(), result.cost, 1e-9 * result.cost);
      ended_at.insert(result.iterations);
    }
  EXPECT_GT(ended_at.size(), 1u);
}

TEST(Status, DivergedIfTheGuessCannotBeSimulated) {
  const ShootingProblem problem = testing::cartpole_swing_up();
  Trajectory guess = constant_controls(problem, 0);
  guess.u(30).setConstant(1e200);
  const SolveResult result = solve(problem, "ilqr", {}, guess);
  EXPECT_EQ(result.status, SolveStatus::diverged);
  EXPECT_NE(result.message.find("knot 3"), std::string::npos) << result.message;
  EXPECT_EQ(result.trajectory.u(30)[0], 1e200);
  EXPECT_TRUE(std::isnan(result.cost));
  EXPECT_TRUE(result.log.empty());
}

TEST(Status, DivergedIfGuessStatesAreNotFinite) {
  const ShootingProblem problem = testing::cartpole_swing_up();
  Trajectory guess = constant_controls(problem, 0);
  guess.x(12)[1] = std::numeric_limits<double>::quiet_NaN();
  const SolveResult result = solve(problem, "fddp", {}, guess);
  EXPECT_EQ(result.status, SolveStatus::diverged);
  // It is compared with the next state of knot 11.
  EXPECT_NE(result.message.find("knot 11"), std::string::npos) << result.message;
}

/// A solver that ends where gradients far exceed rounding.
SolverInfo far_away(SolveStatus status, int iterations) {
  return {.name = "far",
          .control_bounds = BoundSupport::exact,
          .run = [=](const ShootingProblem& problem, const SolverOptions&, const Trajectory&) {
            SolveResult result(problem);
            result.status = status;
            result.message = "it ended";
            result.iterations = iterations;
            result.residuals.stationarity = 1e17;
            return result;
          }};
}

TEST(Status, DivergedIfIterationsEndFarBeyondRounding) {
  const ShootingProblem problem = testing::cartpole_swing_up();
  const auto end = [&](SolveStatus status, int iterations) {
    return solve(problem, far_away(status, iterations), {}, problem.create_trajectory());
  };
  const SolveResult result = end(SolveStatus::max_iterations, 2);
  EXPECT_EQ(result.status, SolveStatus::diverged);
  EXPECT_EQ(result.message, "the iterates diverged; at the end: it ended");
  EXPECT_EQ(end(SolveStatus::line_search_failed, 1).status, SolveStatus::diverged);
  EXPECT_EQ(end(SolveStatus::max_iterations, 0).status, SolveStatus::max_iterations);
  EXPECT_EQ(end(SolveStatus::interrupted, 2).status, SolveStatus::interrupted)
      << "whatever its iterate is like";
}

// Gradients of costs in units of 1e-20 are no larger than in other units.
TEST(Status, LargeWeightsCauseNoDivergence) {
  const double weight = 1e20;
  const ShootingProblem problem =
      testing::tracking_problem(pendulum({}), Integrator::rk4, 20, 0.05, {0, 0},
                                {{M_PI, 0}, {weight, weight}, {weight}, {weight, weight}}, -3, 3);
  const Trajectory guess = constant_controls(problem, 0.1);
  for (const char* name : {"box_fddp", "ipopt"}) {
    EXPECT_EQ(solve(problem, name, {.max_iterations = 2}, guess).status,
              SolveStatus::max_iterations)
        << name;
    EXPECT_EQ(solve(problem, name, {}, guess).status, SolveStatus::converged) << name;
  }
}

TEST(Status, RegularizationLimitNamesTheKnot) {
  // Negative curvature that exceeds the largest regularization, also through the last state.
  const double weight = -4 * SolverOptions::Regularization::kLargest;
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(2, 2), B = Eigen::MatrixXd::Zero(2, 1);
  const ShootingProblem problem =
      testing::tracking_problem(linear_system(A, B, Eigen::VectorXd::Ones(2)), Integrator::discrete,
                                5, 1, {0, 0}, {{1, 1}, {1, 1}, {weight}, {1, 1}});
  for (const char* name : {"fddp", "box_fddp"}) {
    DdpSolver solver(problem, find_ddp_member(name)->recipe, {});
    const SolveResult result = solver.solve(problem.create_trajectory());
    EXPECT_EQ(result.status, SolveStatus::regularization_limit) << result.message;
    EXPECT_NE(result.message.find("knot 4"), std::string::npos) << result.message;
    EXPECT_FALSE(result.feedback_regularization);
    EXPECT_TRUE(finite(result));
  }
}

/// The control, with the derivative of its negative.
class MisledResidual : public ResidualBase<MisledResidual> {
 public:
  explicit MisledResidual(int ndx) : ResidualBase({{1, {ndx}}}, 0, true) {}
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    r[0] = in.u[0];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    r[0] = in.u[0];
    jacobian[0] = S(-1.0);
  }
};

TEST(Status, LineSearchFailedIfNoStepLowersTheCost) {
  const auto system = pendulum({});
  auto model = std::make_shared<KnotModel>(system, Integrator::rk4);
  model->add_cost("effort", std::make_shared<MisledResidual>(2), {});
  std::vector<double> parameters;
  for (int k = 0; k < 5; ++k) parameters.push_back(1);
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  const ShootingProblem problem(
      {0, 0},
      {{.name = "swing",
        .model = model,
        .dt = std::vector<double>(5, 0.1),
        .cost_scale = std::vector<double>(5, 1),
        .parameters = parameters}},
      {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}, .parameters = {}});
  Trajectory guess = constant_controls(problem, 1);
  ASSERT_EQ(Evaluator(problem).simulate(guess), -1);
  const SolveResult result = solve(problem, "ilqr", {}, guess);
  EXPECT_EQ(result.status, SolveStatus::line_search_failed) << result.message;
  EXPECT_TRUE(finite(result));
  EXPECT_NE(result.message.find("no step length"), std::string::npos) << result.message;
}

// Known defect of Crocoddyl and Aligator: steps accepted because they are small.
TEST(Status, GapsCloseWithoutCosts) {
  for (const double limit : {testing::kFree, 10.0}) {
    const std::vector<double> none(4, 0.0);
    const ShootingProblem problem = testing::tracking_problem(
        cartpole({}), Integrator::rk4, 20, 0.05, none, {none, none, {0.0}, none}, -limit, limit);
    Trajectory guess = testing::constant_controls(problem, 1);
    for (int k = 1; k <= problem.knots(); ++k) guess.x(k)[0] = 0.3 * k;
    for (const SolverInfo& solver : solvers()) {
      if (unsupported(solver, problem)) continue;
      const SolveResult result = solve(problem, solver, {}, guess);
      EXPECT_EQ(result.status, SolveStatus::converged) << solver.name << ": " << result.message;
      if (!solver.complementarity) {
        EXPECT_LE(result.iterations, 3) << solver.name;
      }
      EXPECT_EQ(result.cost, 0) << solver.name;
    }
  }
}

TEST(Status, RoundingFloorFailsSearchAtBestIterate) {
  const ShootingProblem problem = testing::quadrotor_move();
  SolverOptions options;
  options.tolerances.stationarity = 1e-300;
  using Names = std::vector<const char*>;
  for (const char* name :
       kSmallSizes ? Names{"box_fddp"} : Names{"ilqr", "ddp", "fddp", "box_ddp", "box_fddp"}) {
    const SolveResult result = solve(problem, name, options, constant_controls(problem, 1.22625));
    EXPECT_EQ(result.status, SolveStatus::line_search_failed) << name << ": " << result.message;
    EXPECT_LE(result.residuals.stationarity, 1e-10) << name;
    for (const IterationRecord& row : result.log) {
      EXPECT_GE(result.residuals.stationarity, 0);
      // Costates along another sweep's policy round differently.
      EXPECT_LE(result.residuals.stationarity, row.stationarity * 1.01) << name;
    }
  }
}

TEST(Status, TightStationarityIsReachedDespiteRounding) {
  const ShootingProblem problem = testing::unicycle_parking(1);
  SolverOptions options;
  options.tolerances.stationarity = 1e-11;
  for (const char* name : {"box_ddp", "box_fddp"}) {
    const SolveResult result = solve(problem, name, options, constant_controls(problem, 0.01));
    EXPECT_EQ(result.status, SolveStatus::converged) << name << ": " << result.message;
  }
}

TEST(Solve, RejectsOptionsProblemsAndGuessesByName) {
  const ShootingProblem bounded = testing::pendulum_swing_up(3);
  const Trajectory guess = bounded.create_trajectory();
  const auto message = [&](std::string_view solver, const SolverOptions& options,
                           const Trajectory& from) -> std::string {
    try {
      solve(bounded, solver, options, from);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const std::string refusal = message("ilqr", {}, guess);
  for (const char* part :
       {"ilqr", "control bounds", "'all'", "-3", "box_ddp", "box_fddp", "ilqr_clip"}) {
    EXPECT_NE(refusal.find(part), std::string::npos) << part << " in: " << refusal;
  }
  EXPECT_NE(message("nonsense", {}, guess).find("nonsense"), std::string::npos);
  EXPECT_NE(message("box_ddp", {.max_iterations = -1}, guess).find("max_iterations"),
            std::string::npos);
  EXPECT_NE(message("ilqr_clip", {.hessian = HessianChoice::exact}, guess).find("hessian"),
            std::string::npos);
  EXPECT_NE(message("box_ddp", {}, Trajectory(2, {1, 1})).find("shape"), std::string::npos);
}

TEST(Solve, RejectsBoundsExactlyIfUnsupported) {
  const ShootingProblem bounded = testing::pendulum_swing_up(3);
  const ShootingProblem free = testing::pendulum_swing_up();
  for (const SolverInfo& solver : solvers()) {
    EXPECT_FALSE(unsupported(solver, free)) << solver.name;
    EXPECT_EQ(unsupported(solver, bounded).has_value(), solver.control_bounds == BoundSupport::none)
        << solver.name;
    EXPECT_EQ(find_solver(solver.name), &solver);
  }
}

}  // namespace
}  // namespace conddp
