#include <cmath>

#include <fmt/format.h>

#include "ocp/evaluation/evaluator.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

TEST(Build, PhasesHaveTheirKnotsAndSteps) {
  const Loaded loaded{std::string(kPendulum)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(problem.knots(), 10);
  EXPECT_EQ(problem.phases().size(), 2u);
  EXPECT_EQ(problem.knot(3).dt, 0.1);
  EXPECT_EQ(problem.knot(4).dt, 0.05);
  EXPECT_EQ(problem.knot(4).cost_scale, 0.05);
  EXPECT_NEAR(problem.times().back(), 0.7, 1e-15);
  EXPECT_EQ(problem.initial_state(), (std::vector<double>{0.1, 0}));
  EXPECT_EQ(problem.phases()[0].model->integrator(), Integrator::rk4);
  EXPECT_EQ(problem.phases()[0].model->control_upper(), std::vector<double>{3});
}

TEST(Build, WarnsAboutJointsStartingOutsideTheirLimits) {
  const auto from = [](const char* state) {
    return replaced(kCartpole, "{configuration: up}", state);
  };
  EXPECT_EQ(warnings(from("{joints: {slider: 2.4}}")), "");
  EXPECT_EQ(warnings(from("{joints: {slider: -3}}")),
            "7:26: the initial state has the joint 'slider' at -3 m, outside of its limits, -2.4 "
            "to 2.4 ()\n");
  const std::string degrees = R"(conddp: 1
robot: {urdf: robots/planar_quadruped.urdf}
initial_state: {joints: {LF_hip: 60}}
phases: [{name: only, knots: 5, dt: 0.1}]
)";
  EXPECT_NE(warnings(degrees).find("angles are in rad: 60° is 1.047 rad"), std::string::npos);
}

TEST(Build, WarnsAboutReferencesOutsideJointLimits) {
  const auto towards = [](const char* cost) {
    return fmt::format(R"(conddp: 1
robot:
  urdf: robots/hopper.urdf
  base: planar
  configurations: {{bent: {{joints: {{hip: 45, knee: -1}}}}}}
initial_state: {{joints: {{hip: 0.5, knee: -1}}}}
phases: [{{knots: 4, dt: 0.05}}]
costs: {{bend: {{{}}}}}
)",
                       cost);
  };
  const std::string at =
      " the reference of 'bend' has the joint 'hip' at 45 rad, outside of its "
      "limits, -1.2 to 1.8 (angles are in rad: 45° is 0.7854 rad)\n";
  EXPECT_EQ(warnings(towards("residual: joint_position, reference: {hip: 45, knee: -1}")),
            "8:54:" + at);
  EXPECT_EQ(warnings(towards("residual: state, reference: {joints: {hip: 45}}")), "8:54:" + at);
  EXPECT_EQ(warnings(towards("residual: state, reference: bent")), "8:44:" + at);
  // Unmentioned coordinates have no reference, and the initial state has its own warning.
  EXPECT_EQ(warnings(towards("residual: joint_position, reference: {hip: 0.4}")), "");
  EXPECT_EQ(warnings(towards("residual: state, reference: initial")), "");
}

TEST(Build, WarnsAboutInitialPenetration) {
  const auto block = [](double height, const std::string& more) {
    return fmt::format(R"(conddp: 1
robot: {{urdf: robots/block.urdf, actuation: {{joints: [base_x]}}}}
initial_state: {{joints: {{base_z: {}}}}}
contact_candidates: {{rear: {{frame: corner_1, against: {{half_space: {{point: [0, 0, 0]}}}}{}}}}}
stepping: {{plane: [0, 1, 0]}}
phases: [{{knots: 4, dt: 0.05}}]
initial_guess: {{states: initial, controls: zero}}
solver: {{name: ipopt}}
)",
                       height, more);
  };
  EXPECT_EQ(warnings(block(2, "")), "");
  EXPECT_EQ(warnings(block(-3, ", stiffness: 1000")), "");
  const std::string said = warnings(block(-3, ""));
  EXPECT_TRUE(said.starts_with("3:16: the initial state has 'rear' 3")) << said;
  EXPECT_NE(said.find("m inside a surface that it may only touch"), std::string::npos) << said;
}

TEST(Build, ReportsJointsWithoutUrdfLimits) {
  const Loaded loaded(R"(conddp: 1
robot: {urdf: robots/double_pendulum.urdf}
initial_state: {}
phases: [{knots: 4, dt: 0.05}]
constraints: {range: {bounds: configuration, from: urdf}}
)");
  ASSERT_NE(loaded.error(), nullptr);
  EXPECT_EQ(loaded.error()->hint, "the URDF limits none of them: give 'lower' and 'upper'");
}

TEST(Build, WarnsAboutControlsWithoutUrdfLimits) {
  const auto with = [](const char* bounds) {
    return std::string(R"(conddp: 1
robot: {urdf: robots/acrobot.urdf}
initial_state: {}
phases: [{knots: 4, dt: 0.05}]
constraints: {torque: {bounds: control, )") +
           bounds + "}}\n";
  };
  const std::string all = warnings(with("from: urdf"));
  EXPECT_TRUE(all.starts_with("5:47: the URDF gives no effort limit to 'u/shoulder' (")) << all;
  EXPECT_EQ(warnings(with("from: urdf, lower: -5, upper: 5")), "");
}

TEST(Build, PlanarBasesHaveNoMotors) {
  const std::string text = R"(conddp: 1
robot: {urdf: robots/hopper.urdf, base: planar}
initial_state: {}
phases: [{knots: 4, dt: 0.05}]
)";
  const Loaded full(text);
  ASSERT_TRUE(full.built) << full.all();
  EXPECT_EQ(full.built->problem->nu(0), 2);
  const Loaded named(text, {"robot.actuation={joints: [base_x, hip]}"});
  ASSERT_TRUE(named.built) << named.all();
  EXPECT_EQ(named.built->problem->nu(0), 2);
}

TEST(Build, WarnsAboutKeyframesAfterTheEnd) {
  const auto at = [](const char* time) {
    return std::string(kCartpole) + "initial_guess: {states: {keyframes: [{time: " + time +
           ", state: up}]}}\n";
  };
  EXPECT_EQ(warnings(at("0.5")), "");
  EXPECT_EQ(warnings(at("5")), "9:45: the motion ends at 0.5 s, before this keyframe ()\n");
}

TEST(Build, WarnsAboutReferencesOutsideTheMotion) {
  const auto at = [](const char* times, const char* values) {
    return warnings(
        fmt::format("{}costs: {{c: {{residual: joint_velocity, reference: {{times: {}, "
                    "values: {}}}}}}}\n",
                    kCartpole, times, values));
  };
  EXPECT_EQ(at("[0, 0.5]", "[0, 1]"), "");
  EXPECT_EQ(at("[0, 0.2, 10]", "[0, 1, 2]"), "");
  EXPECT_EQ(at("[0, 10]", "[0, 1]"), "") << "the beginning of a longer way";
  EXPECT_EQ(at("[0, 100, 500]", "[0, 1, 2]"),
            "9:50: of the 3 times of this reference one lies within the motion, which ends at 0.5 "
            "s: the next one is 100 s (times are in s)\n");
  EXPECT_EQ(at("[10, 20]", "[0, 1]"),
            "9:50: of the 2 times of this reference none lies within the motion, which ends at 0.5 "
            "s: the next one is 10 s (times are in s)\n");
}

TEST(Build, WarnsAboutUnusedSeeds) {
  const auto with = [](const char* perturbation) {
    return warnings(std::string(kCartpole) + "perturbation: " + perturbation + "\n");
  };
  EXPECT_EQ(with("{initial_state: 0.1, seed: 2}"), "");
  EXPECT_EQ(with("{guess: 0.1, seed: 2}"), "");
  EXPECT_EQ(with("{initial_state: 0, guess: 0, seed: 1}"), "") << "as expanded";
  EXPECT_EQ(with("{seed: 2}"),
            "9:22: the seed has no effect, as nothing is perturbed "
            "(write 'perturbation: {initial_state: 0.1, seed: 2}')\n");
}

TEST(Build, PhasesOfOneStructureShareTheirModel) {
  const Loaded same{std::string(kPendulum)};
  ASSERT_TRUE(same.built);
  EXPECT_EQ(same.built->problem->phases()[0].model, same.built->problem->phases()[1].model);
  const Loaded cost(replaced(kPendulum, "weight: 0.5", "weight: 0.5, phases: second"));
  ASSERT_TRUE(cost.built) << cost.all();
  EXPECT_NE(cost.built->problem->phases()[0].model, cost.built->problem->phases()[1].model);
  EXPECT_TRUE(cost.built->problem->phases()[0].model->costs().empty());
  const Loaded bounds(replaced(kPendulum, "upper: 3", "upper: 3, phases: [first]"));
  ASSERT_TRUE(bounds.built) << bounds.all();
  EXPECT_TRUE(bounds.built->problem->phases()[0].model->has_control_bounds());
  EXPECT_FALSE(bounds.built->problem->phases()[1].model->has_control_bounds());
}

TEST(Build, WeightsFollowKnotsAndPhases) {
  std::string text = replaced(kPendulum, "weight: 0.5", "weight: 0.5, knots: [1, 5]");
  text = replaced(text, "dt: 0.05", "dt: 0.05, weights: {effort: 4}");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const int at = problem.knot(0).model->costs()[0].weight;
  for (int k = 0; k < 10; ++k)
    EXPECT_EQ(problem.knot(k).parameters[at], k == 1 ? 0.5 : k == 5 ? 4 : 0) << k;
  EXPECT_EQ(problem.phases()[0].model, problem.phases()[1].model);
}

TEST(Build, PhasesAreNamedByPatterns) {
  const Loaded loaded(replaced(kPendulum, "weight: 0.5", "weight: 0.5, phases: 'sec*'"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->phases()[0].model->costs().size(), 0u);
  EXPECT_EQ(loaded.built->problem->phases()[1].model->costs().size(), 1u);
}

TEST(Build, RunningCostsCanBeSums) {
  const Loaded loaded(replaced(kPendulum, "integrator", "running_costs: sum\nintegrator"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->knot(0).cost_scale, 1);
  EXPECT_EQ(loaded.built->problem->terminal().cost_scale[0], 1);
}

TEST(Build, WayPointsInterpolate) {
  const Loaded loaded(replaced(kPendulum, "costs:\n",
                               "costs:\n  path: {residual: state, reference: {times: [0.1, 0.3], "
                               "values: [{values: {theta: 1}}, [3, 2]]}}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(problem.knot(0).parameters[0], 1);  // before the first one: held
  EXPECT_EQ(problem.knot(1).parameters[0], 1);
  EXPECT_NEAR(problem.knot(2).parameters[0], 2, 1e-12);
  EXPECT_NEAR(problem.knot(2).parameters[1], 1, 1e-12);
  EXPECT_NEAR(problem.knot(9).parameters[0], 3, 1e-12);
}

TEST(Build, DroppedConstraintsAreKeptForTheReport) {
  const Loaded loaded(std::string(kPendulum), {}, {.drop = {"torque"}});
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_FALSE(problem.has_control_bounds());
  ASSERT_EQ(loaded.built->dropped.size(), 1u);
  Trajectory trajectory = problem.create_trajectory();
  trajectory.u(2)[0] = 4.5;
  EXPECT_DOUBLE_EQ(violation(loaded.built->dropped[0], problem, trajectory), 1.5);
}

TEST(Build, BoundsOfSeveralConstraintsIntersect) {
  const Loaded loaded(replaced(kPendulum, "constraints:\n",
                               "constraints:\n  more: {bounds: control, lower: -5, upper: [2]}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->knot(0).model->control_lower(), std::vector<double>{-3});
  EXPECT_EQ(loaded.built->problem->knot(0).model->control_upper(), std::vector<double>{2});
}

TEST(Build, ControlRateAddsPreviousControlToTheState) {
  std::string text = replaced(kPendulum, "costs:\n", "costs:\n  rate: {residual: control_rate}\n");
  text = replaced(text, "{theta: 0.1}}", "{theta: 0.1}, previous_control: 0.7}");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->initial_state(), (std::vector<double>{0.1, 0, 0.7}));
  ASSERT_EQ(loaded.built->state_columns.size(), 3u);
  EXPECT_EQ(loaded.built->state_columns[2].name, "previous/torque");
}

TEST(Build, IntegratorsMatchTheirSystems) {
  const auto integrator = [](const std::string& system, const std::string& state,
                             const std::string& key) {
    const Loaded loaded("conddp: 1\nsystem: " + system + "\ninitial_state: " + state + key +
                        "\nphases: [{knots: 3, dt: 0.1}]\n");
    return loaded.built ? std::optional(loaded.built->problem->knot(0).model->integrator())
                        : std::nullopt;
  };
  EXPECT_EQ(integrator("{type: cartpole}", "{}", ""), Integrator::semi_implicit_euler);
  EXPECT_EQ(integrator("{type: unicycle}", "{}", ""), Integrator::rk4);
  EXPECT_EQ(integrator("{type: car}", "{}", ""), Integrator::discrete);
  EXPECT_EQ(integrator("{type: car}", "{}", "\nintegrator: rk4"), std::nullopt);
  EXPECT_EQ(integrator("{type: unicycle}", "{}", "\nintegrator: discrete"), std::nullopt);
  EXPECT_EQ(integrator("{type: unicycle}", "{}", "\nintegrator: semi_implicit_euler"),
            std::nullopt);
  EXPECT_EQ(integrator("{type: linear, A: [[1, 1], [0, 1]], B: [[0], [1]]}", "{state: [1, 2]}", ""),
            Integrator::discrete);
}

TEST(Build, RobotsUseConfigurationsAsReferences) {
  const Loaded loaded(replaced(
      kCartpole, "phases:",
      "costs:\n"
      "  tip: {residual: frame_position, frame: tip, reference: up}\n"
      "  pose: {residual: frame_placement, frame: tip, reference: initial}\n"
      "  joints: {residual: joint_position, joints: [hinge], reference: {hinge: 2}}\n"
      "  limits: {residual: joint_position, activation: {kind: quadratic_barrier, from: urdf}}\n"
      "  state: {residual: state, reference: up, weights: {slider: 2, \"v/*\": 0.5}}\n"
      "  com: {residual: com_position, reference: initial}\n"
      "  gravity: {residual: control_gravity}\n"
      "phases:"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const KnotModel& model = *loaded.built->problem->knot(0).model;
  const double* p = loaded.built->problem->knot(0).parameters;
  ASSERT_EQ(model.costs().size(), 7u);
  // The pole tip is at (0.5 sin θ, 0, −0.5 cos θ), as the comment in the URDF states.
  EXPECT_NEAR(p[model.costs()[0].parameters], 0.5 * std::sin(3), 1e-12);
  EXPECT_NEAR(p[model.costs()[0].parameters + 2], -0.5 * std::cos(3), 1e-12);
  EXPECT_EQ(p[model.costs()[2].parameters], 2);
  EXPECT_EQ(model.costs()[3].activation.lower[0], -2.4);
  EXPECT_TRUE(std::isinf(model.costs()[3].activation.upper[1]));
  EXPECT_EQ(model.costs()[4].activation.weights, (std::vector<double>{2, 1, 0.5, 0.5}));
  EXPECT_EQ(p[model.costs()[4].parameters + 1], 3);
}

TEST(Build, MostSpecificJointPatternWins) {
  const Loaded loaded(R"(conddp: 1
robots:
  one: {urdf: robots/arm7.urdf, actuation: {joints: [joint_7, "joint_*"]},
        configurations: {bent: {joints: {joint_2: 0.5, "*_3": 0.3, "*": 0.1, "j*_4": 0.4}}}}
  two: {urdf: robots/double_pendulum.urdf, actuation: {joints: ["*oul*"]}}
initial_state: {robots: {one: {configuration: bent, velocity: {joints: {"*_1": 2}}}}}
phases: [{knots: 2, dt: 0.1}]
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double>& x = loaded.built->problem->initial_state();
  EXPECT_EQ(std::vector<double>(x.begin(), x.begin() + 9),
            (std::vector<double>{0.1, 0.5, 0.3, 0.4, 0.1, 0.1, 0.1, 0, 0}));
  EXPECT_EQ(x[9], 2);
  EXPECT_EQ(std::count(x.begin() + 9, x.end(), 0.0), 8);
  ASSERT_EQ(loaded.built->control_columns.size(), 8u);
  EXPECT_EQ(loaded.built->control_columns[7].name, "u/two/shoulder");
}

TEST(Build, BuiltProblemOutlivesItsSpecification) {
  Loaded loaded(kStandingQuadruped + R"(phases: [{knots: 3, dt: 0.02, contacts: all}]
costs:
  effort: {residual: control, weight: 0.1}
  height: {residual: frame_position, frame: trunk, reference: [0, 0, 0.5], weight: 10}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto cost = [&] {
    const ShootingProblem& problem = *loaded.built->problem;
    Evaluation evaluation(problem);
    Evaluator(problem).evaluate(loaded.built->guess, evaluation);
    return evaluation.cost.sum();
  };
  const double before = cost();
  loaded.spec.reset();
  EXPECT_EQ(cost(), before);
  EXPECT_EQ(loaded.built->plant.parts.front().spec->urdf.value, "robots/quadruped.urdf");
}

TEST(Build, SeveralRobotsShareAProblem) {
  const Loaded loaded(R"(conddp: 1
robots:
  arm:
    urdf: robots/double_pendulum.urdf
    configurations: {up: {joints: {shoulder: 3}}}
  box:
    urdf: robots/free_body.urdf
    base: floating
    actuation: none
initial_state:
  robots:
    arm: {configuration: up, velocity: {joints: {elbow: 2}}}
    box: {base: {position: [1, 2, 3], rpy: [0, 0, 1]}}
phases: [{knots: 2, dt: 0.1}]
costs:
  pose: {residual: state, reference: arm/up}
  elbow: {residual: joint_velocity, joints: arm/elbow}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double>& x = loaded.built->problem->initial_state();
  ASSERT_EQ(x.size(), 2u + 7 + 8);
  EXPECT_EQ(x[0], 3);
  EXPECT_EQ(x[2], 1);
  EXPECT_NEAR(x[7], std::sin(0.5), 1e-12);
  EXPECT_EQ(x[10], 2);
  EXPECT_EQ(loaded.built->control_columns.size(), 2u);
  EXPECT_EQ(loaded.built->control_columns[0].name, "u/arm/shoulder");
}

TEST(Build, ThrustersAreTheControlsOfAFloatingBody) {
  const Loaded loaded(R"(conddp: 1
robot:
  urdf: robots/quadrotor.urdf
  base: floating
  actuation:
    thrusters:
      - {name: one, frame: rotor_1, torque_ratio: 0.02, upper: 12}
      - {name: two, frame: rotor_2, direction: [0, 0, 3], lower: null}
initial_state: {base: {position: [0, 0, 1]}}
phases: [{knots: 2, dt: 0.1}]
constraints: {thrust: {bounds: control, from: urdf}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const KnotModel& model = *loaded.built->problem->knot(0).model;
  EXPECT_EQ(model.control_lower()[0], 0);
  EXPECT_EQ(model.control_upper()[0], 12);
  EXPECT_TRUE(std::isinf(model.control_lower()[1]));
}

/// Initial costs of test cases from the literature, with reference values from Altro.jl's problems.
struct InitialCost {
  const char* name;
  std::string text;
  double cost;
};

class LiteratureCase : public testing::TestWithParam<InitialCost> {};

TEST_P(LiteratureCase, HasThePublishedInitialCost) {
  const Loaded loaded(GetParam().text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  Evaluator evaluator(*loaded.built->problem);
  Trajectory trajectory = loaded.built->guess;
  ASSERT_EQ(evaluator.simulate(trajectory), -1);
  Evaluation evaluation(*loaded.built->problem);
  evaluator.evaluate(trajectory, evaluation);
  EXPECT_NEAR(evaluation.cost.sum() / GetParam().cost, 1, 1e-9);
}

std::string literature_text(const std::string& system, const std::string& x0, const std::string& xf,
                            const std::string& integrator, const std::string& phase, double q,
                            double r, double qf, double u) {
  return fmt::format(R"(conddp: 1
system: {{type: {}}}
initial_state: {{state: {}}}
integrator: {}
phases: [{}]
costs:
  state: {{residual: state, reference: {}, weight: {}}}
  control: {{residual: control, weight: {}}}
terminal: {{costs: {{goal: {{residual: state, reference: {}, weight: {}}}}}}}
initial_guess: {{controls: {{constant: {}}}}}
)",
                     system, x0, integrator, phase, xf, q, r, xf, qf, u);
}

constexpr const char* kPi = "3.141592653589793";

INSTANTIATE_TEST_SUITE_P(
    Altro, LiteratureCase,
    testing::Values(
        InitialCost{"Pendulum",
                    literature_text("pendulum", "[0, 0]", fmt::format("[{}, 0]", kPi), "rk4",
                                    "{knots: 50, duration: 3}", 1e-3, 1e-3, 1, 0.1),
                    4.913747482},
        InitialCost{"CartpoleRk3",
                    literature_text("cartpole", "[0, 0, 0, 0]", fmt::format("[0, {}, 0, 0]", kPi),
                                    "rk3", "{knots: 100, duration: 5}", 0.01, 0.1, 100, 0.01),
                    494.453188503},
        InitialCost{"CartpoleRk4",
                    literature_text("cartpole", "[0, 0, 0, 0]", fmt::format("[0, {}, 0, 0]", kPi),
                                    "rk4", "{knots: 100, duration: 5}", 0.01, 0.1, 100, 0.01),
                    494.451492216},
        InitialCost{"Acrobot",
                    literature_text("acrobot", "[-1.5707963267948966, 0, 0, 0]",
                                    "[1.5707963267948966, 0, 0, 0]", "rk4",
                                    "{knots: 100, duration: 5}", 1, 0.01, 100, 0),
                    518.154231057}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace conddp
