// Every diagnosis pattern, provoked by a problem that ends that way.
#include "analysis/findings/diagnosis.hpp"

#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

struct Provocation {
  std::string name;
  DiagnosisPattern pattern;
  std::string quantity;
  std::string problem;
  std::vector<std::string> settings;
  std::vector<std::string> drop;
};

class DiagnosisOf : public ::testing::TestWithParam<Provocation> {};

TEST_P(DiagnosisOf, ARealSolve) {
  const Provocation& p = GetParam();
  Diagnostics out;
  const auto file = source_tree() / "problems" / (p.problem + ".yaml");
  const auto spec = read_problem(file, p.settings, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {.drop = p.drop}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  const SolveResult result =
      solve(*built->problem, spec->solver.name.value, spec->solver.options, built->guess);
  const Diagnosis d = diagnose(*built->problem, result, spec->solver.options);
  EXPECT_EQ(to_string(d.pattern), to_string(p.pattern)) << result.message << "\n" << d.message;
  EXPECT_EQ(d.quantity, p.quantity);
  EXPECT_FALSE(d.message.empty());
  const bool normal = p.pattern == DiagnosisPattern::normal;
  EXPECT_EQ(d.remedy.empty(), normal);
  EXPECT_EQ(d.knot < 0, normal) << d.knot;
  EXPECT_LE(d.knot, built->problem->knots());
}

INSTANTIATE_TEST_SUITE_P(
    Patterns, DiagnosisOf,
    ::testing::Values(
        Provocation{"Normal", DiagnosisPattern::normal, "", "pendulum_swingup", {}, {}},
        Provocation{"Unfinished",
                    DiagnosisPattern::unfinished,
                    "stationarity",
                    "cartpole_swingup",
                    {"solver.max_iterations=2"},
                    {}},
        // Controls that make any pendulum diverge.
        Provocation{"Growth",
                    DiagnosisPattern::growth,
                    "cost or next state",
                    "acrobot_swingup",
                    {"solver.name=ilqr", "initial_guess.controls={constant: 1.0e+200}"},
                    {"torque"}},
        // A foot whose steps grow a thousandfold from knot to knot, and the value with them.
        Provocation{"Indefinite",
                    DiagnosisPattern::indefinite,
                    "Q_uu",
                    "hopper_jump",
                    {"contacts.foot.baumgarte={kp: 1.0e+6, kd: 1000}"},
                    {}},
        // A mass that reaches only 1.2 m under its speed limit.
        Provocation{"Infeasible",
                    DiagnosisPattern::infeasible,
                    "constraint violation",
                    "double_integrator_limits",
                    {"terminal.constraints.goal.reference=[5, 0]"},
                    {}},
        Provocation{"RoundingFloor",
                    DiagnosisPattern::rounding_floor,
                    "stationarity",
                    "quadrotor_waypoints",
                    {"solver.tolerances={stationarity: 1.0e-18}"},
                    {}},
        // States at rest do not follow such controls.
        Provocation{"OpenGaps",
                    DiagnosisPattern::open_gaps,
                    "gap",
                    "acrobot_swingup",
                    {"solver={name: box_fddp, max_iterations: 5}",
                     "initial_guess.controls={random: {seed: 1, scale: 30}}"},
                    {}},
        // Clipping does not descend, and regularization grows until the decrease vanishes; rounding
        // is not the cause.
        Provocation{"Plateau",
                    DiagnosisPattern::plateau,
                    "stationarity",
                    "car_parking",
                    {"solver={name: ilqr_clip, max_iterations: 100}"},
                    {}},
        // Penalties start low and hardly grow.
        Provocation{"SlowFeasibility",
                    DiagnosisPattern::slow_feasibility,
                    "constraint violation",
                    "unicycle_obstacles",
                    {"solver.max_iterations=60",
                     "solver.augmented_lagrangian={initial_penalty: "
                     "0.01, penalty_factor: 1.1}"},
                    {}},
        // Clipping does not descend.
        Provocation{"NoDescent",
                    DiagnosisPattern::no_descent,
                    "merit",
                    "double_pendulum_swingup",
                    {"solver.name=ilqr_clip", "phases=[{knots: 30, dt: 0.2}]"},
                    {}}),
    [](const auto& p) { return p.param.name; });

}  // namespace
}  // namespace conddp
