// Phases with free durations.
#include <cmath>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "analysis/certificate/replay.hpp"
#include "analysis/derivatives/derivative_check.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// A mass moves one meter from rest to rest as fast as its force allows.
const std::string kFastest = R"(conddp: 1
system: {type: double_integrator, dimension: 1}
initial_state: {state: [0, 0]}
integrator: rk2
phases:
  - {name: start, choose: none}
  - {name: push, knots: 10, duration: 1, free_duration: {lower: 0.1, upper: 10}}
  - {name: brake, knots: 10, duration: 1, free_duration: {}}
costs:
  time: {residual: combination, rows: {constant: 1}, weight: 2}
constraints:
  force: {bounds: control, lower: -1, upper: 2}
terminal:
  constraints:
    there: {residual: state, reference: [1, 0]}
solver: {name: ipopt}
)";

/// The small pendulum with a free duration of the second phase and costs that grow with it.
const std::string kFreePendulum =
    replaced(replaced(replaced(kPendulum, "name: box_ddp", "name: ipopt"), "phases:\n",
                      "phases:\n  - {name: start, choose: omega, lower: -1, upper: 1}\n"),
             "dt: 0.05}", "dt: 0.05, free_duration: {lower: 0.1, upper: 2}}");

/// A floating robot with one free phase duration.
std::string floating(const std::string& integrator) {
  return "conddp: 1\nrobot:\n  urdf: robots/free_body.urdf\n  base: floating\n"
         "  actuation: {thrusters: [{name: a, frame: body}, "
         "{name: b, frame: body, direction: [1, 2, 3]}]}\n"
         "initial_state: {base: {position: [1, 2, 3], rpy: [0.3, -0.2, 0.5]}}\n"
         "integrator: " +
         integrator +
         "\nphases:\n  - {name: start, choose: \"base/v*\"}\n"
         "  - {name: free, knots: 3, dt: 0.1, free_duration: {}}\n"
         "  - {name: given, knots: 2, dt: 0.2}\n"
         "costs: {effort: {residual: control, weight: 0.3}, way: {residual: state}}\n"
         "solver: {name: ipopt}\n";
}

/// A block of 1 kg on ground with friction 0.5 is dragged 5 m, from rest to rest, by at most 40 N.
constexpr std::string_view kDrag = R"(conddp: 1
robot: {urdf: robots/block.urdf, actuation: {joints: [base_x]}}
initial_state: {joints: {base_z: 0.5}}
contact_candidates:
  rear: {frame: corner_1, friction: 0.5}
  front: {frame: corner_2, friction: 0.5}
stepping: {plane: [0, 1, 0]}
phases: [{name: drag, knots: 40, duration: 1, free_duration: {lower: 0.2, upper: 3}}]
costs:
  time: {residual: combination, rows: {constant: 1}, weight: 2}
  effort: {residual: control, weight: 1.0e-6}
constraints: {force: {bounds: control, lower: -40, upper: 40}}
terminal:
  constraints:
    there: {residual: joint_position, joints: [base_x], reference: 5}
    rest: {residual: joint_velocity, joints: [base_x]}
initial_guess: {states: {keyframes: [{time: 1, state: {joints: {base_x: 5, base_z: 0.5}}}]}}
solver: {name: ipopt, complementarity: {initial: 0.1}}
)";

// Friction brakes: (40 − 4.905) N accelerate the block and (40 + 4.905) N stop it.
TEST(FreeDuration, ContactImplicitStepsStretch) {
  const Loaded loaded{std::string(kDrag)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result =
      solve(*loaded.built->problem, "ipopt", loaded.spec->solver.options, loaded.built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const double fastest = std::sqrt(2 * 5 * (1 / (40 - 4.905) + 1 / (40 + 4.905)));
  const double time = result.trajectory.x(1)[loaded.built->problem->nx() - 1];
  EXPECT_GE(time, fastest);
  EXPECT_NEAR(time, fastest, 1e-3 * fastest) << "steps of equal length switch late";
  for (const DerivativeComparison& c : check_derivatives(*loaded.built->problem, result.trajectory))
    EXPECT_LT(c.error, kDerivativeTolerance) << c.knot << " " << c.row << " " << c.column;
}

// Stepping equations of a floating body depend on the duration through a rotation.
TEST(FreeDuration, StepsOfFloatingBodiesStretch) {
  std::ifstream file(kProblems / "crate_tumble.yaml");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const Loaded loaded(text, {"phases.0.free_duration={}"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const DerivativeComparison& c :
       check_derivatives(*loaded.built->problem, loaded.built->guess))
    EXPECT_LT(c.error, kDerivativeTolerance) << c.knot << " " << c.row << " " << c.column;
}

TEST(FreeDuration, IsChosenFirstAndHeld) {
  const Loaded loaded(kFastest);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(problem.nx(), 4);
  EXPECT_EQ(problem.nu(0), 2);
  EXPECT_EQ(problem.knot(0).model->control_lower(), (std::vector<double>{0.1, 0.1}));
  EXPECT_EQ(problem.knot(0).model->control_upper(), (std::vector<double>{10, 10}));
  Trajectory t = loaded.built->guess;
  EXPECT_EQ(t.u(0)[0], 1);
  EXPECT_EQ(t.x(7)[3], 1);
  t.u(0) << 2, 0.5;
  ASSERT_EQ(Evaluator(problem).simulate(t), -1);
  const std::vector<double> times = problem.times(t);
  EXPECT_NEAR(times[1], 0, 1e-15);
  EXPECT_NEAR(times[6], 1, 1e-12);
  EXPECT_NEAR(times[11], 2, 1e-12);
  EXPECT_NEAR(times[21], 2.5, 1e-12);
  EXPECT_EQ(problem.times()[21], 2) << "as the file has it";
  EXPECT_EQ(loaded.built->state_columns[2].name, "start/duration/push");
  EXPECT_EQ(loaded.built->state_columns[3].unit, "s");
}

TEST(FreeDuration, StepsFollowTheDuration) {
  for (const char* integrator : {"semi_implicit_euler", "explicit_euler", "rk2", "rk3", "rk4"}) {
    const std::string text = floating(integrator);
    const Loaded free(text), longer(replaced(text, "knots: 3, dt: 0.1", "knots: 3, dt: 0.25"));
    ASSERT_TRUE(free.built && longer.built) << free.all() << longer.all();
    const auto end = [](const Loaded& loaded) {
      Trajectory t = loaded.built->guess;
      for (int k = 0; k < t.knots(); ++k)
        for (int i = 0; i < t.u(k).size(); ++i) t.u(k)[i] = std::sin(1 + 3 * k + i);
      t.u(0).tail(1)[0] = 0.75;
      EXPECT_EQ(Evaluator(*loaded.built->problem).simulate(t), -1);
      Evaluation values(*loaded.built->problem);
      Evaluator(*loaded.built->problem).evaluate(t, values);
      return std::pair(Eigen::VectorXd(t.x(t.knots())), values.cost.sum());
    };
    EXPECT_LT((end(free).first - end(longer).first).cwiseAbs().maxCoeff(), 1e-13) << integrator;
    EXPECT_NEAR(end(free).second, end(longer).second, 1e-12 * end(free).second) << integrator;
  }
}

TEST(FreeDuration, StepDerivativesMatchDualNumbers) {
  for (const std::string& text :
       {kFastest, kFreePendulum, replaced(kFreePendulum, "rk4", "rk3"),
        replaced(kFreePendulum, "integrator: rk4", "integrator: rk4\nrunning_costs: sum"),
        floating("semi_implicit_euler"), floating("explicit_euler"), floating("rk4")}) {
    const Loaded loaded(text);
    ASSERT_TRUE(loaded.built) << loaded.all();
    for (const DerivativeComparison& c :
         check_derivatives(*loaded.built->problem, loaded.built->guess))
      EXPECT_LT(c.error, 1e-9) << "phase " << c.phase << ", row " << c.row << ", column "
                               << c.column << text;
  }
}

/// With forces of at most 2 forwards and 1 backwards, the mass accelerates for √(1/3) s and brakes
/// for twice as long.
TEST(FreeDuration, DoubleIntegratorTimeMatchesBangBang) {
  const Loaded loaded(kFastest);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result =
      solve(*loaded.built->problem, "ipopt", loaded.spec->solver.options, loaded.built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.cost, std::sqrt(3), 1e-7);
  EXPECT_NEAR(loaded.built->problem->times(result.trajectory).back(), result.cost, 1e-7);
  double forwards = 0, backwards = 0;
  const std::vector<double> times = loaded.built->problem->times(result.trajectory);
  for (int k = 1; k < result.trajectory.knots(); ++k) {
    const double force = result.trajectory.u(k)[0], step = times[k + 1] - times[k];
    (force > 0 ? forwards : backwards) += std::abs(force) * step;
  }
  EXPECT_NEAR(forwards, 2 / std::sqrt(3), 1e-6);
  EXPECT_NEAR(backwards, 2 / std::sqrt(3), 1e-6);
}

/// Controls are at their bounds nearly everywhere, and time is the only cost. The active bounds are
/// hard to detect and must be exact to close the gaps.
TEST(FreeDuration, CoversAQuadrotorWithSaturatedControls) {
  const Loaded loaded(R"(conddp: 1
system: {type: planar_quadrotor}
initial_state: {values: {z: 1}}
integrator: rk4
phases:
  - {name: start, choose: none}
  - {name: move, knots: 60, duration: 2, free_duration: {lower: 0.1, upper: 20}}
costs:
  time: {residual: combination, rows: {constant: 1}, weight: 2}
constraints:
  limits: {bounds: control, lower: 0, upper: 8}
terminal:
  constraints:
    goal: {residual: state, reference: {values: {x: 3, z: 2}}}
solver: {name: ipopt}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = solve(*loaded.built->problem, *find_solver("ipopt"),
                                   loaded.spec->solver.options, loaded.built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  int inside = 0;
  for (int k = 1; k < loaded.built->problem->knots(); ++k)
    for (const double u : result.trajectory.u(k)) inside += u > 1e-9 && u < 8 - 1e-9;
  EXPECT_LE(inside, 10);
}

/// No given duration improves on the optimal one.
TEST(FreeDuration, IsOptimal) {
  const std::string costs = replaced(
      kFreePendulum, "costs:\n",
      "costs:\n  time: {residual: combination, rows: {constant: 1, theta: 0}, weight: 0.3}\n");
  const std::string text = replaced(costs, "choose: omega, lower: -1, upper: 1", "choose: none");
  for (const char* solver : {"box_fddp", "altro", "proxddp", "ipopt"}) {
    const Loaded free(text);
    ASSERT_TRUE(free.built) << free.all();
    const SolveResult best = solve(*free.built->problem, solver, {}, free.built->guess);
    ASSERT_EQ(best.status, SolveStatus::converged) << solver << ": " << best.message;
    const double duration = best.trajectory.u(0)[0];
    EXPECT_GT(duration, 0.11) << solver;
    EXPECT_LT(duration, 1.9) << solver;
    for (const double factor : {1.0, 0.97, 1.03}) {
      const std::string fixed_text =
          replaced(replaced(text, "  - {name: start, choose: none}\n", ""),
                   "dt: 0.05, free_duration: {lower: 0.1, upper: 2}",
                   "duration: " + std::to_string(duration * factor));
      const Loaded fixed(fixed_text);
      ASSERT_TRUE(fixed.built) << fixed.all();
      const SolveResult other = solve(*fixed.built->problem, "ipopt", {}, fixed.built->guess);
      ASSERT_EQ(other.status, SolveStatus::converged) << other.message;
      if (factor == 1)
        EXPECT_NEAR(other.cost, best.cost, 1e-6 * best.cost) << solver;
      else
        EXPECT_GT(other.cost, best.cost * (1 + 1e-5)) << solver;
    }
  }
}

/// A hopper with a periodic hop, contacts, flight, and an impact. It chooses its initial state and
/// the durations of push, flight, and landing.
TEST(FreeDuration, CoversAHopperWithContactsAndImpact) {
  const std::string text = replaced(
      hopper_with_free_durations(),
      "phases: flight, weight: 100,\n               swing: {height: 0.08, step: [0.3, 0, 0]}}",
      "phases: flight, weight: 0.1, reference: [0, 0, 0.1]}");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const DerivativeComparison& c :
       check_derivatives(*loaded.built->problem, loaded.built->guess))
    EXPECT_LT(c.error, 1e-6) << "phase " << c.phase << ", row " << c.row << ", column " << c.column;
  const SolveResult result =
      solve(*loaded.built->problem, "altro", loaded.spec->solver.options, loaded.built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const std::vector<double> times = loaded.built->problem->times(result.trajectory);
  EXPECT_NEAR(times[46] - times[21], result.trajectory.u(0).tail(1)[0], 1e-9) << "the flight";
  EXPECT_LT(times.back(), 0.5) << "shorter than the 0.6 s of the file";
}

TEST(FreeDuration, BeginsWithAnEarlierSolution) {
  const TemporaryFolder folder;
  const std::string file =
      folder.write("start.json", R"({"format": "conddp.solution/1", "trajectory": {
    "columns": {"x": ["q/0", "v/0", "start/duration/push", "start/duration/brake"], "u": ["u/0"]},
    "phases": [{"name": "start", "knots": 1}, {"name": "push", "knots": 2},
               {"name": "brake", "knots": 2}],
    "t": [0, 0, 0.3, 0.6, 1.1, 1.6],
    "x": [[0, 0, 0, 0], [0, 0, 0.6, 1], [1, 2, 0.6, 1], [3, 4, 0.6, 1], [5, 6, 0.6, 1],
          [7, 8, 0.6, 1]],
    "u": [[0.6, 1], [2], [2], [-1], [-0.5]]}})");
  for (const int knots : {2, 4, 10}) {
    const std::string own = "knots: " + std::to_string(knots);
    const Loaded loaded(replaced(replaced(kFastest, "push, knots: 10", "push, " + own),
                                 "brake, knots: 10", "brake, " + own) +
                        "initial_guess: {file: " + file + "}\n");
    ASSERT_TRUE(loaded.built) << loaded.all();
    const Trajectory& guess = loaded.built->guess;
    EXPECT_DOUBLE_EQ(guess.u(0)[0], 0.6);
    EXPECT_DOUBLE_EQ(guess.u(0)[1], 1);
    for (int k = 1; k <= guess.knots(); ++k) {
      EXPECT_DOUBLE_EQ(guess.x(k)[2], 0.6);
      EXPECT_DOUBLE_EQ(guess.x(k)[3], 1);
    }
    for (int k = 1; k <= guess.knots(); ++k) {
      const double node = 2. * (k - 1) / knots;  // of the file, from the first push
      EXPECT_NEAR(guess.x(k)[0], node < 1 ? node : 2 * node - 1, 1e-12) << knots << ", " << k;
    }
    EXPECT_EQ(guess.u(1 + knots / 2)[0], 2);
    EXPECT_EQ(guess.u(1 + knots)[0], -1) << "from the end of the push on";
    EXPECT_EQ(guess.u(2 * knots)[0], -0.5);
    EXPECT_EQ(loaded.diagnostics.list().size(), 0u) << loaded.all();
  }
}

/// A guess neither balances the choice against gravity nor clamps it.
TEST(FreeDuration, KeepsGuessedControls) {
  const std::string torque = "constraints:\n  force: {bounds: control, lower: -5, upper: 5}\n";
  const std::string text = replaced(
      floating("rk4"), "solver:", torque + "initial_guess: {controls: quasi_static}\nsolver:");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_DOUBLE_EQ(loaded.built->guess.u(0).tail(1)[0], 0.3);
}

TEST(FreeDuration, IsReplayedInItsOwnTime) {
  const Loaded loaded(kFreePendulum);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result =
      solve(*loaded.built->problem, "ipopt", loaded.spec->solver.options, loaded.built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const double written = 0.3;
  ASSERT_GT(std::abs(result.trajectory.u(0)[1] - written), 0.05);
  const Replay replayed = replay(*loaded.built->problem, result.trajectory, result.feedback.K, 1);
  EXPECT_LT(replayed.controls.deviation, 1e-7);
  EXPECT_LT(replayed.feedback.deviation, 1e-7);
}

TEST(FreeDuration, InfiniteDerivativesPreventConvergence) {
  const Loaded loaded(
      "conddp: 1\nsystem: {states: [x], controls: [u], rate: {x: u}}\n"
      "initial_state: {values: {x: 1}}\n"
      "phases: [{choose: none}, {knots: 10, dt: 0.1, free_duration: {lower: 0.1}}]\n"
      "costs: {effort: {residual: control}}\n"
      "terminal: {costs: {time: {residual: expression, rows: final_time, activation: linear}}}\n");
  ASSERT_TRUE(loaded.spec) << loaded.all();
  ProblemSpec spec = *loaded.spec;
  spec.phases[1].free_duration->lower = 1e-310;
  Diagnostics out;
  const auto built = build_problem(spec, {}, out);
  ASSERT_TRUE(built);
  for (const char* solver : {"box_fddp", "altro"}) {
    const SolveResult result = solve(*built->problem, solver, {}, built->guess);
    EXPECT_TRUE(!is_success(result.status) || std::isfinite(result.cost)) << solver;
  }
}

}  // namespace
}  // namespace conddp
