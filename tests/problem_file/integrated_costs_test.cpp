// Running costs integrated by the stages of the integrator.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "analysis/derivatives/derivative_check.hpp"
#include "analysis/derivatives/node_models.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

std::shared_ptr<const ShootingProblem> problem_of(const std::string& text) {
  const Loaded loaded(text);
  EXPECT_TRUE(loaded.built) << loaded.all();
  return loaded.built ? loaded.built->problem : nullptr;
}

/// Motion under controls that change from knot to knot.
Trajectory motion_of(const ShootingProblem& problem) {
  Trajectory motion = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k)
    for (double& u : motion.u(k)) u = std::sin(0.7 * k);
  EXPECT_EQ(Evaluator(problem).simulate(motion), -1);
  return motion;
}

double cost_of(const ShootingProblem& problem) {
  Evaluation values(problem);
  Evaluator(problem).evaluate(motion_of(problem), values);
  return values.cost.sum();
}

/// The van der Pol oscillator; `count` is the rate of a state that integrates the cost.
std::string oscillator(const std::string& head, const std::string& phases, const std::string& cost,
                       bool as_state) {
  std::string text = "conddp: 1\nsystem:\n  controls: [u]\n  states: [x, y" +
                     std::string(as_state ? ", total]" : "]") +
                     "\n  rate: {x: (1 - y^2)*x - y + u, y: x" +
                     (as_state ? ", total: \"" + cost + "\"" : "") +
                     "}\ninitial_state: {values: {y: 1}}\n" + head + "phases: " + phases;
  text += as_state ? "\nterminal: {costs: {total: {residual: expression, rows: total, activation: "
                     "linear}}}\n"
                   : "\nrunning_costs: integrated\ncosts: {total: {residual: expression, rows: \"" +
                         cost + "\", activation: linear}}\n";
  return text;
}

constexpr const char* kWays[][2] = {
    {"", "[{knots: 6, duration: 2}, {knots: 4, duration: 1}]"},
    {"controls: linear\n", "[{choose: none}, {knots: 6, duration: 2}, {knots: 4, duration: 1}]"},
    {"",
     "[{choose: none}, {knots: 6, duration: 2, free_duration: {lower: 1, upper: 3}}, {knots: 4, "
     "duration: 1}]"}};

TEST(IntegratedCosts, MatchAnIntegratingState) {
  for (const char* rule : {"rk2", "rk3", "rk4"})
    for (const auto& [head, phases] : kWays) {
      const std::string keys = fmt::format("integrator: {}\n{}", rule, head);
      if (rule == std::string("rk2") && keys.find("linear") != std::string::npos) continue;
      SCOPED_TRACE(keys + phases);
      const std::string cost = "x^2 + y*x + exp(y)*u^2";
      const auto integrated = problem_of(oscillator(keys, phases, cost, false));
      const auto counted = problem_of(oscillator(keys, phases, cost, true));
      ASSERT_TRUE(integrated && counted);
      const double expected = cost_of(*counted);
      EXPECT_NEAR(cost_of(*integrated), expected, 1e-12 * std::abs(expected));
    }
}

TEST(IntegratedCosts, CollocationMatchesAnIntegratingState) {
  const std::string head = "solver: {name: altro, tolerances: {stationarity: 1.0e-9}}\n";
  for (const char* rule : {"trapezoidal", "hermite_simpson", "radau3", "radau5"})
    for (const auto& [more, phases] : kWays) {
      const std::string keys = fmt::format("integrator: {}\n{}{}", rule, head, more);
      SCOPED_TRACE(keys + phases);
      double costs[2];
      for (const bool as_state : {false, true}) {
        const Loaded loaded(oscillator(keys, phases, "x^2 + y^2 + exp(y)*u^2 + 0.5*u^2", as_state));
        ASSERT_TRUE(loaded.built) << loaded.all();
        const SolveResult result = solve(*loaded.built->problem, "altro",
                                         loaded.spec->solver.options, loaded.built->guess);
        ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
        costs[as_state] = result.cost;
      }
      EXPECT_NEAR(costs[0], costs[1], 1e-7 * costs[1]);
    }
}

/// Costs of every kind, with time-varying references.
std::string all_kinds(const std::string& rule, const std::string& way) {
  return fmt::format(R"(conddp: 1
system: {{states: [x, y], controls: [u], rate: {{x: (1 - y^2)*x - y + u, y: x}}}}
initial_state: {{values: {{x: 0.3, y: 1}}}}
integrator: {}
running_costs: integrated
{}
costs:
  way: {{residual: expression, rows: [x, y - sin(t), phase_time*x], weight: 2}}
  long: {{residual: expression, rows: [x + y^2*u, x], activation: smooth_l2}}
  short: {{residual: state, activation: smooth_l1, weights: [1, 2]}}
  effort: {{residual: control, weight: 2, reference: {{times: [0, 3], values: [0, 1]}}}}
  inside: {{residual: state, activation: {{kind: quadratic_barrier, lower: -0.1, upper: 0.1}}}}
  loss: {{residual: expression, rows: exp(x)*u^2, activation: linear}}
  pulled: {{residual: state, matrix: [[2], [0.5, 1]]}}
)",
                     rule, way);
}

TEST(IntegratedCosts, HaveExactGradients) {
  for (const char* rule :
       {"rk2", "rk3", "rk4", "trapezoidal", "hermite_simpson", "radau3", "radau5"})
    for (const auto& [head, phases] : kWays) {
      if (rule == std::string("rk2") && std::string(head).find("linear") != std::string::npos)
        continue;
      const Loaded loaded(all_kinds(rule, fmt::format("{}phases: {}", head, phases)));
      ASSERT_TRUE(loaded.built) << loaded.all();
      for (const DerivativeComparison& c :
           check_derivatives(*loaded.built->problem, loaded.built->guess))
        EXPECT_LE(c.error, kDerivativeTolerance) << rule << phases << c.knot << " " << c.column;
    }
}

TEST(IntegratedCosts, RobotInContactHasExactGradients) {
  const Loaded loaded(kStandingQuadruped + R"(integrator: rk4
running_costs: integrated
phases: [{knots: 3, dt: 0.02, contacts: all}, {knots: 2, dt: 0.02, contacts: [LF, RH]}]
costs:
  state: {residual: state}
  torque: {residual: control, weight: 0.01}
  force: {residual: contact_force, weight: 0.001}
  cone: {residual: friction_cone}
  acceleration: {residual: joint_acceleration, weight: 0.001}
  foot: {residual: frame_position, frame: lf_foot, reference: {times: [0, 0.1], values: [[0, 0, 0], [1, 0, 0]]}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const DerivativeComparison& c :
       check_derivatives(*loaded.built->problem, loaded.built->guess))
    EXPECT_LE(c.error, kDerivativeTolerance) << c.knot << " " << c.row << " " << c.column;
}

/// For squares of linear functions along linear motions, the Gauss-Newton Hessian is exact.
TEST(IntegratedCosts, HaveExactHessiansOnLinearMotions) {
  for (const char* rule :
       {"rk2", "rk3", "rk4", "trapezoidal", "hermite_simpson", "radau3", "radau5"})
    for (const char* way : {"phases: [{knots: 3, dt: 0.4}]",
                            "controls: linear\nphases: [{choose: none}, {knots: 3, dt: 0.4}]"}) {
      if (rule == std::string("rk2") && std::string(way).starts_with("controls")) continue;
      const auto problem = problem_of(fmt::format(R"(conddp: 1
system: {{states: [x, y], controls: [u], rate: {{x: u - y, y: x - 0.3*y}}}}
initial_state: {{values: {{y: 1}}}}
integrator: {}
running_costs: integrated
{}
costs: {{way: {{residual: expression, rows: [x + 2*u, y]}}, effort: {{residual: control}}}}
)",
                                                  rule, way));
      ASSERT_TRUE(problem);
      const Trajectory at = problem->create_trajectory();
      const auto approximate = gauss_newton_hessians(*problem, at);
      const auto exact =
          exact_hessians(*problem, at, Eigen::MatrixXd::Zero(problem->ndx(), problem->knots() + 1));
      for (std::size_t k = 0; k < exact.size(); ++k)
        EXPECT_LE((approximate[k] - exact[k]).cwiseAbs().maxCoeff(), 1e-12) << rule << way << k;
    }
}

/// ∫½x² of x' = 1 − x from 0 over 1 s is ½ (1 − 2 (1 − e⁻¹) + ½ (1 − e⁻²)).
TEST(IntegratedCosts, HaveTheOrderOfTheRule) {
  const double exact = 0.5 * (1 - 2 * (1 - std::exp(-1.0)) + 0.5 * (1 - std::exp(-2.0)));
  const auto error = [&](const char* rule, const char* kind, int knots) {
    const auto problem = problem_of(
        fmt::format("conddp: 1\nsystem: {{states: [x], controls: [u], rate: {{x: 1 - x + 0*u}}}}\n"
                    "initial_state: {{}}\nintegrator: {}\nrunning_costs: {}\n"
                    "phases: [{{knots: {}, duration: 1}}]\ncosts: {{x: {{residual: state}}}}\n",
                    rule, kind, knots));
    return std::abs(cost_of(*problem) - exact);
  };
  for (const auto& [rule, order] :
       {std::pair{"rk2", 2}, std::pair{"rk3", 3}, std::pair{"rk4", 4}}) {
    EXPECT_NEAR(std::log2(error(rule, "integrated", 16) / error(rule, "integrated", 32)), order,
                0.2)
        << rule;
    EXPECT_NEAR(std::log2(error(rule, "rate", 16) / error(rule, "rate", 32)), 1, 0.2) << rule;
  }
}

/// x' = u with ½ ∫ (x² + u²) over 1 s from x = 1 has the minimum ½ tanh 1.
TEST(IntegratedCosts, ReachTheOptimumInContinuousTime) {
  for (const char* rule : {"rk4", "hermite_simpson", "radau5"})
    for (const char* solver : {"ddp", "box_fddp", "altro", "proxddp", "ipopt"}) {
      if (std::string(rule) != "rk4" && *solver != 'a' && *solver != 'p' && *solver != 'i')
        continue;
      const Loaded loaded(fmt::format(R"(conddp: 1
system: {{states: [x], controls: [u], rate: {{x: u}}}}
initial_state: {{values: {{x: 1}}}}
integrator: {}
running_costs: integrated
controls: linear
phases: [{{choose: none}}, {{knots: 20, duration: 1}}]
costs: {{state: {{residual: state}}, effort: {{residual: control}}}}
solver: {{tolerances: {{constraint: 1.0e-9}}}}
)",
                                      rule));
      ASSERT_TRUE(loaded.built) << loaded.all();
      const SolveResult result =
          solve(*loaded.built->problem, solver, loaded.spec->solver.options, loaded.built->guess);
      ASSERT_EQ(result.status, SolveStatus::converged) << rule << solver << result.message;
      EXPECT_NEAR(result.cost, 0.5 * std::tanh(1.0), 1e-6) << rule << solver;
    }
}

/// A cost of time depends only on the duration.
TEST(IntegratedCosts, TimeCostEqualsTheDuration) {
  const Loaded loaded(R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: u}}
initial_state: {}
integrator: rk4
running_costs: integrated
phases: [{choose: none}, {knots: 5, duration: 1.5, free_duration: {lower: 1, upper: 2}}]
costs: {time: {residual: combination, rows: {constant: 1}, weight: 2}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  Evaluation values(problem);
  Evaluator(problem).evaluate(loaded.built->guess, values);
  EXPECT_NEAR(values.cost.sum(), 1.5, 1e-12);
  for (const auto& [name, cost] : cost_by_name(problem, NodeValues(problem, loaded.built->guess)))
    EXPECT_NEAR(cost, 1.5, 1e-12) << name;
  for (const DerivativeComparison& c : check_derivatives(problem, loaded.built->guess))
    EXPECT_LE(c.error, kDerivativeTolerance) << c.knot << " " << c.column;
}

TEST(IntegratedCosts, InstantaneousCostsAreUnchanged) {
  const auto text = [](const char* integrator, const char* kind) {
    return replaced(replaced(kPendulum, "integrator: rk4",
                             fmt::format("integrator: {}\nrunning_costs: {}", integrator, kind)),
                    "  effort: {residual: control, weight: 0.5}\n",
                    "  rate: {residual: control_rate}\n  gate: {residual: state, knots: [3]}\n");
  };
  const double expected = cost_of(*problem_of(text("rk4", "rate")));
  EXPECT_EQ(cost_of(*problem_of(text("rk4", "integrated"))), expected);
  const auto plain = [](const char* kind) {
    return replaced(kPendulum, "integrator: rk4",
                    fmt::format("integrator: semi_implicit_euler\nrunning_costs: {}", kind));
  };
  EXPECT_EQ(cost_of(*problem_of(plain("integrated"))), cost_of(*problem_of(plain("rate"))));
}

TEST(IntegratedCosts, NeedStatesBetweenNodes) {
  const Loaded loaded(
      "conddp: 1\nsystem: {states: [x], controls: [u], next: {x: x + u}}\ninitial_state: {}\n"
      "running_costs: integrated\nphases: [{knots: 3, dt: 0.1}]\ncosts: {u: {residual: "
      "control}}\n");
  EXPECT_FALSE(loaded.built);
  EXPECT_NE(loaded.all().find("4:16: error: steps that give the next state themselves"),
            std::string::npos)
      << loaded.all();
}

}  // namespace
}  // namespace conddp
