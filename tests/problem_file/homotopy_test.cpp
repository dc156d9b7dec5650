// Homotopies of problem files, and the scale of URDF limits that they often use.
#include "problem_file/assemble/homotopy.hpp"

#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

std::string with_homotopy(const std::string& list, std::string_view text = kPendulum) {
  return replaced(text, "solver: {name: box_ddp}",
                  "solver: {name: box_ddp, homotopy: " + list + "}");
}

const std::string kTorque =
    "[{key: constraints.torque.lower, from: -6, to: -3}, {key: constraints.torque.upper, from: 6, "
    "to: 3}]";

double upper_at(const Loaded& loaded, double share) {
  const auto problem = homotopy_path(*loaded.built)(share);
  return problem ? problem->knot(0).model->control_upper()[0] : -1;
}

TEST(HomotopyFile, MovesAllNumbersTogether) {
  const Loaded loaded(with_homotopy(kTorque));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_TRUE(loaded.diagnostics.list().empty()) << loaded.all();
  const ProblemPath path = homotopy_path(*loaded.built);
  for (const double share : {0.0, 0.25, 1.0}) {
    const auto problem = path(share);
    ASSERT_TRUE(problem);
    const double expected = 6 * std::pow(0.5, share);  // same sign: geometric steps
    EXPECT_NEAR(problem->knot(0).model->control_upper()[0], expected, 1e-14);
    EXPECT_NEAR(problem->knot(0).model->control_lower()[0], -expected, 1e-14);
  }
  EXPECT_EQ(upper_at(loaded, 0), 6);
  EXPECT_EQ(upper_at(loaded, 1), 3);
}

TEST(HomotopyFile, NumbersThroughZeroMoveInEqualSteps) {
  const Loaded loaded(with_homotopy("[{key: initial_state.values.theta, from: -0.3, to: 0.1}]"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NEAR(homotopy_path(*loaded.built)(0.25)->initial_state()[0], -0.2, 1e-15);
}

TEST(HomotopyFile, OtherUsersSeeTheProblemAtItsEnd) {
  const Loaded plain{std::string(kPendulum)}, loaded(with_homotopy(kTorque));
  EXPECT_EQ(loaded.built->problem->knot(0).model->control_upper()[0], 3);
  auto a = expand_problem(*plain.built), b = expand_problem(*loaded.built);
  EXPECT_NE(a, b);
  b["solver"]["homotopy"].clear();
  EXPECT_EQ(a, b);
  EXPECT_FALSE(homotopy_path(*plain.built));
}

TEST(HomotopyFile, WarnsIfFileDiffersFromItsEnd) {
  const std::string text = with_homotopy("[{key: costs.effort.weight, from: 5, to: 2}]");
  EXPECT_EQ(warnings(text),
            "10:39: 0.5 has no effect: a homotopy moves this number to 2 (write that number here, "
            "too)\n");
  const Loaded loaded(text);
  EXPECT_EQ(loaded.spec->costs[0].weight, 2);
}

TEST(HomotopyFile, MayMoveNumbersLeftAtTheirDefault) {
  const std::string text = std::string(kCartpole) + R"(costs: {effort: {residual: control}}
constraints: {force: {bounds: control, from: urdf}}
solver: {homotopy: [{key: constraints.force.scale, from: 3, to: 1}]}
)";
  EXPECT_EQ(warnings(text), "");
  const Loaded loaded(text);
  EXPECT_EQ(loaded.built->problem->knot(0).model->control_upper()[0], 10);
  EXPECT_EQ(upper_at(loaded, 0), 30);
}

TEST(HomotopyFile, NamesPhases) {
  const Loaded loaded(with_homotopy("[{key: phases.second.dt, from: 0.1, to: 0.05}]"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(homotopy_path(*loaded.built)(0)->times(loaded.built->guess).back(), 1);
  EXPECT_EQ(loaded.spec->phases[1].dt, 0.05);
}

TEST(HomotopyFile, CanBeSetOnTheCommandLine) {
  const Loaded loaded(std::string(kPendulum), {"solver.homotopy=" + kTorque});
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(upper_at(loaded, 0), 6);
}

TEST(HomotopyFile, OutlivesTheFile) {
  ProblemPath path;
  {
    const Loaded loaded(with_homotopy(kTorque));
    path = homotopy_path(*loaded.built);
  }
  EXPECT_EQ(path(0)->knots(), 10);
  EXPECT_EQ(path(0.5)->create_trajectory().x(0)[0], 0.1);
}

// Expansion turns a gait into phases and contact defaults into values of each contact, so moving
// numbers take their expanded names.
TEST(HomotopyFile, ExpandsToTheNumbersThatItMoves) {
  const std::string text = R"(conddp: 1
robot: {urdf: robots/quadruped.urdf, base: floating}
contacts:
  defaults: {friction: 0.15}
  LF: {frame: lf_foot}
  RH: {frame: rh_foot}
initial_state: {base: {position: [0, 0, 0.57]}}
phases: [{name: stand, knots: 3, dt: 0.02, contacts: all}]
costs: {effort: {residual: control}}
solver: {homotopy: [{key: contacts.defaults.friction, from: 0.7, to: 0.15}]}
)";
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const OrderedJson expanded = expand_problem(*loaded.built);
  EXPECT_EQ(expanded["solver"]["homotopy"].dump(),
            R"([{"key":"contacts.LF.friction","from":0.7,"to":0.15},)"
            R"({"key":"contacts.RH.friction","from":0.7,"to":0.15}])");
  const Loaded again(expanded_text(*loaded.built));
  ASSERT_TRUE(again.built) << again.all();
  EXPECT_EQ(expand_problem(*again.built), expanded);
}

struct BadHomotopy {
  std::string list;
  std::string where;  ///< text at the place of the error, at its last occurrence
  const char* message;
};

class BadHomotopies : public testing::TestWithParam<BadHomotopy> {};

TEST_P(BadHomotopies, AreReportedAtTheirPlaces) {
  const Loaded loaded(with_homotopy(GetParam().list));
  EXPECT_FALSE(loaded.built);
  ASSERT_TRUE(loaded.error());
  EXPECT_EQ(loaded.error()->line, 16);
  const std::string line = replaced("solver: {name: box_ddp, homotopy: @}", "@", GetParam().list);
  EXPECT_EQ(loaded.error()->column, line.rfind(GetParam().where) + 1) << loaded.error()->message;
  EXPECT_NE(loaded.error()->message.find(GetParam().message), std::string::npos)
      << loaded.error()->message;
}

INSTANTIATE_TEST_SUITE_P(
    Classes, BadHomotopies,
    testing::Values(
        BadHomotopy{"{}", "{}", "a list is expected here, not a mapping"},
        BadHomotopy{"[{from: 1, to: 2}]", "{from", "'key'"},
        BadHomotopy{"[{key: costs.effort.weight, from: 1, to: 2, too: 2}]", "too",
                    "unknown key 'too'"},
        BadHomotopy{"[{key: costs.effort.weight, from: 1, to: x}]", "x}", "'x' is not a number"},
        BadHomotopy{"[{key: costs.effort.weight, from: 2, to: 2}]", "2}", "nothing moves"},
        BadHomotopy{"[{key: costs.efort.weight, from: 1, to: 2}]", "costs", "there is no 'efort'"},
        BadHomotopy{"[{key: costs.effort.wight, from: 1, to: 2}]", "costs", "unknown key 'wight'"},
        BadHomotopy{"[{key: costs.effort.residual, from: 1, to: 2}]", "costs",
                    "'costs.effort.residual' is a word and no number"},
        BadHomotopy{"[{key: costs.effort, from: 1, to: 2}]", "costs", "is a mapping and no number"},
        BadHomotopy{"[{key: phases.5.dt, from: 1, to: 2}]", "phases", "there is no '5'"},
        BadHomotopy{"[{key: solver.max_iterations, from: 1, to: 2}]", "solver",
                    "is not a number of the problem itself"},
        BadHomotopy{"[{key: phases.0.dt, from: -1, to: 0.1}]", "phases",
                    "the problem at 0.382 of the homotopy cannot be built: a positive number"},
        BadHomotopy{"[{key: phases.0.dt, from: 0.2, to: -0.1}]", "-0.1", "a positive number"},
        BadHomotopy{"[{key: phases.0.knots, from: 8, to: 4}]", "phases",
                    "the problem at 0.382 of the homotopy cannot be built: a whole number"},
        BadHomotopy{"[{key: phases.0.dt, from: 5, to: 3}, {key: phases.0.dt, from: 6, to: 3}]",
                    "phases", "has the key 'phases.0.dt' twice"}));

TEST(HomotopyFile, CannotChangeTheShapeOfTheProblem) {
  const Loaded loaded(replaced(
      with_homotopy("[{key: terminal.constraints.goal.lower, from: 1, to: 2}]"), "terminal:\n",
      "terminal:\n  constraints:\n    goal: {residual: state, lower: 2, upper: 2}\n"));
  EXPECT_FALSE(loaded.built);
  EXPECT_EQ(loaded.first_error(),
            "18:42: a homotopy cannot change the shape of the problem: between 0.382 of its way "
            "and its end these differ: constraints");
}

std::string limited(const std::string& robot, const std::string& constraint) {
  return "conddp: 1\nrobot: {urdf: robots/" + robot +
         ".urdf}\ninitial_state: {}\nphases: [{name: only, "
         "knots: 3, dt: 0.1}]\ncosts: {effort: {residual: control}}\nconstraints:\n  limit: {" +
         constraint + "}\n";
}

TEST(LimitScale, MultipliesEffortsAndVelocities) {
  const Loaded plain(limited("arm7", "bounds: control, from: urdf")),
      scaled(limited("arm7", "bounds: control, from: urdf, scale: 0.5"));
  ASSERT_TRUE(scaled.built) << scaled.all();
  for (int i = 0; i < 7; ++i) {
    const auto& model = *scaled.built->problem->knot(0).model;
    EXPECT_EQ(model.control_upper()[i],
              0.5 * plain.built->problem->knot(0).model->control_upper()[i]);
    EXPECT_EQ(model.control_lower()[i], -model.control_upper()[i]);
  }
  const Loaded speed(limited("arm7", "bounds: velocity, from: urdf")),
      faster(limited("arm7", "bounds: velocity, from: urdf, scale: 2"));
  const NodeConstraint &a = speed.built->problem->constraints()[0],
                       &b = faster.built->problem->constraints()[0];
  for (int i = 0; i < a.term->rows; ++i) EXPECT_EQ(b.upper[i], 2 * a.upper[i]);
}

TEST(LimitScale, WidensPositionsAboutTheirMiddle) {
  const Loaded plain(limited("biped", "bounds: configuration, from: urdf")),
      scaled(limited("biped", "bounds: configuration, from: urdf, scale: 3"));
  ASSERT_TRUE(scaled.built) << scaled.all();
  const NodeConstraint &a = plain.built->problem->constraints()[0],
                       &b = scaled.built->problem->constraints()[0];
  bool uneven = false;
  for (int i = 0; i < a.term->rows; ++i) {
    EXPECT_NEAR(b.upper[i] + b.lower[i], a.upper[i] + a.lower[i], 1e-12);
    EXPECT_NEAR(b.upper[i] - b.lower[i], 3 * (a.upper[i] - a.lower[i]), 1e-12);
    uneven = uneven || a.upper[i] != -a.lower[i];
  }
  EXPECT_TRUE(uneven) << "the robot has a joint whose range is not symmetric";
}

TEST(LimitScale, IsPositiveAndForUrdfLimitsOnly) {
  const Loaded zero(limited("arm7", "bounds: control, from: urdf, scale: 0")),
      own(limited("arm7", "bounds: control, lower: -1, scale: 2"));
  EXPECT_NE(zero.first_error().find("a positive number is expected here"), std::string::npos);
  EXPECT_NE(own.first_error().find("only limits of the URDF are scaled"), std::string::npos);
}

}  // namespace
}  // namespace conddp
