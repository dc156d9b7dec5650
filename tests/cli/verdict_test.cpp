// Verdicts of solve for unusual units and stationary points.
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// A pendulum of unit mass and length hanging at rest.
const std::string kHanging = R"(conddp: 1
name: hanging
system:
  positions: {angle: rad}
  velocities: {rate: rad/s}
  controls: {torque: Nm}
  acceleration: {rate: torque - sin(angle)}
initial_state: {values: {angle: 0}}
phases: [{knots: 40, dt: 0.1}]
costs: {effort: {residual: control, weight: 0.02}}
terminal:
  costs:
)";

/// A problem text and its solution.
class Solved {
 public:
  explicit Solved(const std::string& text, std::vector<std::string> arguments = {}) {
    const std::string file = folder_.path() / "problem.yaml";
    std::ofstream(file) << text;
    arguments.insert(arguments.begin(), {"solve", file, "-o", folder_.path() / "out"});
    run = run_conddp(arguments);
    document = Json::parse(read_file(solution()));
  }

  std::string solution() const { return folder_.path() / "out/solution.json"; }
  double cost() const { return document.at("cost"); }
  std::string verdict() const { return document.at("certificate").at("verdict"); }

  ProcessResult run;
  Json document;

 private:
  TemporaryFolder folder_;
};

// The height of the tip: at rest, its derivative with respect to the torque vanishes.
TEST(Verdicts, ASwingUpFromRestLeavesTheSaddle) {
  const Solved swing(kHanging +
                     "    tip: {residual: expression, rows: {x: sin(angle), z: -cos(angle)}, "
                     "reference: [0, 1], weight: 10}\n");
  EXPECT_EQ(swing.run.exit_code, 0) << swing.run.err;
  EXPECT_EQ(swing.verdict(), "local_minimum");
  EXPECT_LT(swing.cost(), 1) << "at rest 20";
  EXPECT_EQ(run_conddp({"verify", swing.solution(), "--quiet"}).exit_code, 0);
}

// A weight so large that its gradient alone determines the scale.
TEST(Verdicts, GoalWeightsDoNotHideTheEffort) {
  const auto cost = [](const char* weight) {
    const Solved swing(
        kHanging + "    up: {residual: state, reference: {values: {angle: 3}}, weight: " + weight +
        "}\n");
    EXPECT_EQ(swing.run.exit_code, 0) << swing.run.err;
    EXPECT_EQ(swing.verdict(), "local_minimum");
    return swing.cost();
  };
  const double usual = cost("1e4");
  EXPECT_NEAR(cost("1e7"), usual, 1e-3 * usual);
  EXPECT_NEAR(cost("1e10"), usual, 1e-3 * usual);
}

// DDP solvers stop short in the narrow valley of a goal and report it.
TEST(Verdicts, HeavyGoalsAreCertifiedOnlyAtTheirOptimum) {
  const auto solved = [](const std::string& weight, const std::string& solver) {
    return Solved(kHanging + "    up: {residual: state, reference: {values: {angle: 3}}, weight: " +
                      weight + "}\n",
                  {"--solver", solver});
  };
  const double optimum = solved("1e11", "auto").cost();
  for (const char* weight : {"1e11", "1e12", "1e14"})
    for (const char* solver : {"ddp", "box_fddp", "ipopt"}) {
      const Solved heavy = solved(weight, solver);
      EXPECT_TRUE(heavy.verdict() != "local_minimum" || heavy.cost() < (1 + 2e-5) * optimum)
          << solver << " " << weight << ": " << heavy.cost();
    }
}

/// One step of length 1 with this rate and these costs, from x = 0 and u = 0.
Solved one_step(const std::string& rate, const std::string& costs, const std::string& more = "") {
  return Solved("conddp: 1\nname: step\nsystem: {states: {x: m}, controls: {u: m/s}, rate: {x: \"" +
                    rate +
                    "\"}}\ninitial_state: {values: {x: 0}}\nphases: [{knots: 1, dt: 1}]\n"
                    "costs:\n  effort: {residual: control, weight: 0.1}\n" +
                    costs + more,
                {"--solver", "altro"});
}

// Zero solves the equations of one branch each.
TEST(Verdicts, KinksWithDescentAreNotCertified) {
  const std::string goal = "terminal: {costs: {goal: {residual: state, reference: [1]}}}\n";
  for (const char* rate : {"max(0, u)", "u*sign(u)", "if(u > 0, u, 0)"}) {
    const Solved kink = one_step(rate, goal);
    EXPECT_EQ(kink.document.at("trajectory").at("u")[0][0], 0.0) << rate;
    EXPECT_EQ(kink.verdict(), "stationary") << rate;
    EXPECT_NE(kink.run.out.find("kink of the dynamics"), std::string::npos) << kink.run.out;
  }
  const Solved cost =
      one_step("u", "  ridge: {residual: expression, rows: \"min(0, u)\", activation: linear}\n");
  EXPECT_EQ(cost.verdict(), "stationary");
  EXPECT_NE(cost.run.out.find("kink of cost 'ridge'"), std::string::npos) << cost.run.out;
}

TEST(Verdicts, KinksWithoutDescentAreCertified) {
  const auto term = [](const std::string& row) {
    return "  edge: {residual: expression, rows: \"" + row + "\", activation: linear}\n";
  };
  EXPECT_EQ(one_step("u", term("max(0, -u)")).verdict(), "local_minimum");
  // The side that falls is out of bounds.
  EXPECT_EQ(
      one_step("u", term("-max(0, -u)"), "constraints: {forward: {bounds: control, lower: 0}}\n")
          .verdict(),
      "local_minimum");
}

// A straight motion towards a disc from its axis, which no control leaves.
TEST(Verdicts, StraightMotionTowardsADiscIsASaddle) {
  const Solved point(R"(conddp: 1
name: disc
system:
  states: {x: m, y: m, vx: m/s, vy: m/s}
  controls: {ux: N, uy: N}
  rate: {x: vx, y: vy, vx: ux, vy: uy}
initial_state: {values: {x: -1}}
phases: [{knots: 30, duration: 2}]
costs: {effort: {residual: control, weight: 0.001}}
constraints: {disc: {residual: state, columns: [x, y], reference: [0, 0], at_least: 0.4}}
terminal: {costs: {goal: {residual: state, reference: [1, 0, 0, 0], weight: 100}}}
)",
                     {"--solver", "ipddp"});
  EXPECT_EQ(point.verdict(), "local_minimum") << point.run.out;
  EXPECT_LT(point.cost(), 0.01) << "along the axis 13";
}

TEST(Verdicts, ReachesAGoalSmallerThanItsTolerance) {
  const Solved stage(R"(conddp: 1
name: stage
system: {states: [x], controls: [v], rate: {x: v}}
initial_state: {values: {x: 0}}
phases: [{knots: 10, duration: 1}]
costs: {effort: {residual: control}}
terminal: {constraints: {there: {residual: state, reference: [2.0e-7]}}}
)");
  EXPECT_EQ(stage.run.exit_code, 0) << stage.run.err;
  EXPECT_NEAR(stage.cost(), 2e-14, 2e-20);
  EXPECT_EQ(stage.verdict(), "local_minimum");
}

/// A train of 400 t in SI units brakes from 80 m/s to 20 m/s over 25 km in minimum time, with a
/// bound on motor power.
const std::string kTrain = R"yaml(conddp: 1
name: train
system:
  states: {s: m, v: m/s, used: J}
  controls: {force: N}
  let: {m: 400000.0, drag: 6000 + 9.0*v^2}
  rate: {s: v, v: (force - drag)/m, used: "0.5*(force*v + smooth_abs(force*v, 1.0e5))"}
initial_state: {values: {v: 80}}
integrator: rk4
phases:
  - {name: start, choose: none}
  - {name: ride, knots: 60, duration: 500, free_duration: {lower: 100, upper: 5000}}
costs:
  time: {residual: expression, rows: "1", activation: linear}
  smooth: {residual: control, weight: 1.0e-11}
constraints:
  engines: {bounds: control, lower: -300000, upper: 250000}
  energy: {bounds: state, upper: {used: 4.0e8}}
terminal:
  constraints: {there: {residual: state, reference: {values: {s: 25000, v: 20}}, columns: [s, v]}}
initial_guess: {states: interpolate}
)yaml";

TEST(Verdicts, SweepsSupportLargeUnits) {
  std::vector<double> costs;
  for (const char* solver : {"altro", "proxddp"}) {
    const Solved ride(kTrain, {"--solver", solver});
    EXPECT_EQ(ride.run.exit_code, 0) << solver << ride.run.err << ride.run.out;
    EXPECT_EQ(ride.verdict(), "local_minimum") << solver;
    EXPECT_NE(std::string(ride.document.at("message")).find("in units of"), std::string::npos);
    costs.push_back(ride.cost());
  }
  EXPECT_NEAR(costs[1], costs[0], 1e-5 * costs[0]);
}

// The row and its bound in another unit, so that tolerances admit the whole violation.
TEST(Verdicts, RowsInSmallUnitsAreNotIgnored) {
  const auto wall = [](const std::string& row, const std::string& bound) {
    return Solved(
        "conddp: 1\nname: wall\nsystem: {states: [x, v], controls: [a], rate: {x: v, v: a}}\n"
        "initial_state: {values: {x: 0, v: 1}}\nphases: [{knots: 100, duration: 1}]\n"
        "costs: {effort: {residual: control}}\n"
        "constraints: {wall: {residual: expression, rows: " +
        row + ", upper: " + bound +
        "}}\n"
        "terminal: {constraints: {back: {residual: state, reference: [0, -1]}}}\n");
  };
  const Solved usual = wall("x", "0.12"), small = wall("1.0e-6*x", "0.12e-6");
  EXPECT_EQ(small.run.exit_code, 0) << small.run.err;
  EXPECT_EQ(small.verdict(), "local_minimum");
  EXPECT_NEAR(small.cost(), usual.cost(), 1e-4 * usual.cost());
  EXPECT_NE(small.run.err.find("no more than the tolerance of violations"), std::string::npos);
  EXPECT_EQ(usual.run.err.find("tolerance of violations"), std::string::npos);
}

// The multipliers of the two constraints are not unique.
TEST(Verdicts, EqualityMayLieOnABound) {
  for (const char* solver : {"altro", "proxddp", "ipopt"}) {
    const Solved cart(
        "conddp: 1\nname: cart\nsystem: {states: [x, v], controls: [a], rate: {x: v, v: a}}\n"
        "initial_state: {}\nphases: [{knots: 40, duration: 2}]\ncosts: {effort: {residual: "
        "control}}\n"
        "constraints: {speed: {bounds: state, lower: {v: -1}, upper: {v: 1}}}\n"
        "terminal: {constraints: {there: {residual: state, reference: [1.2, 1]}}}\n",
        {"--solver", solver});
    EXPECT_EQ(cart.run.exit_code, 0) << solver << cart.run.err;
    EXPECT_EQ(cart.verdict(), "local_minimum") << solver;
  }
}

// At rest, the rows of the dynamics are nearly dependent along the horizon.
TEST(Verdicts, LongHorizonsDoNotSlowIpopt) {
  const Solved bead(
      "conddp: 1\nname: bead\nsystem: {states: {x: m, y: m, v: m/s}, controls: {g: rad},\n"
      "  rate: {x: v*cos(g), y: v*sin(g), v: 9.81*(sin(g) - 0.1*cos(g))}}\n"
      "initial_state: {}\nintegrator: rk4\nphases: [{name: start, choose: none},\n"
      "  {name: slide, knots: 2500, duration: 1, free_duration: {lower: 0.1, upper: 5}}]\n"
      "costs: {time: {residual: expression, rows: \"1\", activation: linear}}\n"
      "terminal: {constraints: {there: {residual: state, columns: [x, y],\n"
      "  reference: {values: {x: 2, y: 1}}}}}\n"
      "initial_guess: {states: interpolate, controls: {constant: 0.6}}\n",
      {"--solver", "ipopt", "--max-time", "60"});
  EXPECT_EQ(bead.run.exit_code, 0) << bead.run.err;
  EXPECT_EQ(bead.document.at("status"), "converged");
}

// The answer moved back to its start: its claims are true, but descent is possible.
TEST(Verdicts, CostlierMotionIsNotVerified) {
  const Solved stage(R"(conddp: 1
name: flat
system: {states: [x], controls: [v], next: {x: x + v}}
initial_state: {values: {x: 0}}
phases: [{knots: 2, dt: 1}]
costs: {effort: {residual: control, weight: 1.0e-3}}
terminal: {constraints: {there: {residual: state, reference: [1.0e-3]}}}
)");
  ASSERT_EQ(stage.run.exit_code, 0) << stage.run.err;
  Json forged = stage.document;
  forged.erase("certificate");
  const double early = 0.9e-3, late = 0.1e-3;
  forged["trajectory"]["u"] = {{early}, {late}};
  forged["trajectory"]["x"][1] = {early};
  forged["trajectory"]["x"][2] = {early + late};
  const double cost = 0.5e-3 * (early * early + late * late);
  forged["cost"] = forged["cost_by_name"]["effort"] = cost;
  forged["log"].back()["cost"] = cost;
  std::ofstream(stage.solution()) << forged.dump();
  const ProcessResult verified = run_conddp({"verify", stage.solution()});
  EXPECT_EQ(verified.exit_code, 1);
  EXPECT_NE(verified.out.find("would gain or repair"), std::string::npos) << verified.out;
}

/// A point moving along a line with a terminal condition on its position.
std::string point(const std::string& row, double reference) {
  return R"(conddp: 1
name: point
system: {states: {x: m}, controls: {u: m/s}, rate: {x: u}}
initial_state: {values: {x: 0}}
phases: [{knots: 10, dt: 0.1}]
costs: {effort: {residual: control}}
terminal: {constraints: {end: {residual: expression, rows: {row: ")" +
         row + "\"}, reference: [" + std::to_string(reference) + "]}}}\n";
}

// At the start, the row is at its maximum: its derivative vanishes and the violation is maximal.
TEST(Verdicts, SaddleOfTheViolationIsNotInfeasible) {
  for (const char* solver : {"altro", "proxddp", "ipopt"}) {
    const Solved away(point("cos(x)", 0), {"--solver", solver});
    EXPECT_EQ(away.run.exit_code, 0) << solver << away.run.out << away.run.err;
    EXPECT_EQ(away.verdict(), "local_minimum") << solver;
  }
}

TEST(Verdicts, MinimumOfTheViolationIsInfeasible) {
  for (const char* solver : {"altro", "proxddp", "ipopt"}) {
    const Solved stuck(point("cos(x)", 2), {"--solver", solver});
    EXPECT_EQ(stuck.run.exit_code, 1) << solver;
    EXPECT_EQ(stuck.document.at("status"), "infeasible") << solver << stuck.run.out;
    EXPECT_EQ(run_conddp({"verify", stuck.solution(), "--quiet"}).exit_code, 0) << solver;
  }
}

/// A mass on dry ground with friction up to 2 N.
const std::string kHeld = R"(conddp: 1
name: held
system:
  positions: {x: m}
  velocities: {v: m/s}
  controls: {force: N}
  acceleration: {v: force - 2*tanh(v/1.0e-3)}
integrator: radau5
initial_state: {values: {x: 0, v: 0}}
phases: [{knots: 40, dt: 0.05}]
costs: {effort: {residual: control}}
terminal: {constraints: {there: {residual: state, reference: [1, 0]}}}
)";

// At rest, the position hardly depends on a zero force.
TEST(Verdicts, FlatViolationIsNotInfeasible) {
  for (const char* solver : {"auto", "altro", "proxddp", "ipopt"}) {
    const Solved held(kHeld, {"--solver", solver});
    EXPECT_NE(held.document.at("status"), "infeasible") << solver << held.run.out;
  }
}

/// A passive bar falls on its end, tips, and slides. The steps leave the split of friction between
/// two directions open.
TEST(Verdicts, DeterminedStepsConverge) {
  TemporaryFolder folder;
  std::ofstream(std::string(folder.path()) + "/bar.urdf") << R"(<robot name="bar">
<link name="world"/>
<joint name="x" type="prismatic"><parent link="world"/><child link="a"/><axis xyz="1 0 0"/>
<limit lower="-5" upper="5" effort="20" velocity="10"/></joint><link name="a"/>
<joint name="z" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-5" upper="5" effort="20" velocity="10"/></joint><link name="b"/>
<joint name="tilt" type="continuous"><parent link="b"/><child link="bar"/><axis xyz="0 1 0"/></joint>
<link name="bar"><inertial><mass value="1.5"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.012"
iyz="0" izz="0.012"/></inertial></link></robot>)";
  const std::string file = std::string(folder.path()) + "/bar.yaml";
  std::ofstream(file) << R"(conddp: 1
name: bar
robot: {urdf: bar.urdf, actuation: {joints: [x]}}
initial_state: {joints: {z: 0.25, tilt: 0.15}, velocity: {joints: {x: 0.8}}}
contact_candidates:
  left: {frame: bar, point: [-0.12, 0, -0.04], friction: 0.4}
  right: {frame: bar, point: [0.12, 0, -0.04], friction: 0.4}
stepping: {plane: [0, 1, 0]}
phases: [{name: fall, knots: 14, dt: 0.02}]
constraints: {none: {bounds: control, lower: 0, upper: 0}}
costs: {speed: {residual: state, columns: ["v/*"], weight: 1.0e-2}}
)";
  const std::string out = std::string(folder.path()) + "/out";
  const ProcessResult run = run_conddp({"solve", file, "-o", out});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_EQ(Json::parse(read_file(out + "/solution.json")).at("status"), "converged");
}

// Steps may be twice as long as the wall is thick, so that all answers on the file's grid jump
// across it.
TEST(Verdicts, FinerGridsLeadAround) {
  const Solved around(R"(conddp: 1
name: wall
system:
  states: {x: m, y: m, heading: rad}
  controls: {v: m/s, turn: rad/s}
  rate: {x: v*cos(heading), y: v*sin(heading), heading: turn}
initial_state: {values: {x: 0, y: 0.02}}
phases: [{name: go, knots: 10, duration: 1}]
costs: {effort: {residual: control, weight: 0.01}}
constraints:
  speed: {bounds: control, lower: [-3, -20], upper: [3, 20]}
  wall: {residual: state, columns: [x, y], centers: [{from: [1, -0.2], to: [1, 0.2], count: 5}], at_least: 0.08}
terminal: {constraints: {goal: {residual: state, columns: [x, y], reference: [2, 0]}}}
)");
  EXPECT_EQ(around.run.exit_code, 0) << around.run.out << around.run.err;
  EXPECT_EQ(around.run.out.find("jumps through an obstacle"), std::string::npos) << around.run.out;
  double aside = 0;
  for (const Json& x : around.document.at("trajectory").at("x"))
    aside = std::max(aside, std::abs(x[1].get<double>()));
  EXPECT_GT(aside, 0.2);
  EXPECT_EQ(run_conddp({"verify", around.solution(), "--quiet"}).exit_code, 0);
}

// The first answer of auto leads through the lowest part of a double well.
TEST(Verdicts, AutoLooksBeyondItsFirstAnswer) {
  const Solved wells(
      R"(conddp: 1
name: wells
system: {states: {x: m}, controls: {u: m/s}, rate: {x: u}}
initial_state: {values: {x: 0.2}}
phases: [{knots: 10, dt: 0.1}]
costs: {effort: {residual: control, weight: 1.0e-3}}
terminal: {costs: {wells: {residual: expression, rows: {depth: "(x^2 - 1)^2 + 0.3*x"}, activation: linear}}}
)");
  EXPECT_EQ(wells.run.exit_code, 0) << wells.run.out << wells.run.err;
  EXPECT_GE(wells.document.at("attempts").size(), 3u);
  EXPECT_LT(wells.cost(), 0) << "of the nearer well 0.29";
  EXPECT_EQ(run_conddp({"verify", wells.solution(), "--quiet"}).exit_code, 0);
}

}  // namespace
}  // namespace conddp
