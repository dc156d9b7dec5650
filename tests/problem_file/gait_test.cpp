// Expansion of a gait in a problem file: phases, impulses, footholds, and a base path.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "schema_document.hpp"

namespace conddp {
namespace {

const std::string kQuadruped = R"(conddp: 1
robot:
  urdf: robots/quadruped.urdf
  base: floating
  configurations:
    standing:
      base: {position: [0.3, -0.2, 0.57], rpy: [0, 0, 0.5]}
      joints:
        {LF_HAA: -0.2, LF_HFE: 0.75, LF_KFE: -1.5, RF_HAA: -0.2, RF_HFE: 0.75, RF_KFE: -1.5,
         LH_HAA: -0.2, LH_HFE: -0.75, LH_KFE: 1.5, RH_HAA: -0.2, RH_HFE: -0.75, RH_KFE: 1.5}
contacts: {LF: {frame: lf_foot}, RF: {frame: rf_foot}, LH: {frame: lh_foot}, RH: {frame: rh_foot}}
initial_state: {configuration: standing}
gait: {type: trot, period: 0.4, dt: 0.02}
costs:
  posture: {residual: state, reference: {configuration: standing, displaced: gait}}
terminal:
  costs:
    rest: {residual: state, reference: {configuration: standing, displaced: gait}}
)";

std::string with_gait(const std::string& gait) {
  return replaced(kQuadruped, "type: trot, period: 0.4, dt: 0.02", gait);
}

/// Null for costs without a swing.
const SwingSpec* swing_of(const CostSpec& cost) { return cost.keys.find(key::swing); }

/// Feet held in each phase, as "LF RH", with the number of knots; impulses as "! LF RH".
std::vector<std::string> schedule(const Loaded& loaded) {
  std::vector<std::string> lines;
  for (const PhaseSpec& phase : loaded.spec->phases) {
    std::string line = phase.restitution ? "!" : fmt::format("{}:", phase.knots.value);
    for (const Name& contact : phase.contacts.names) line += " " + contact.value;
    lines.push_back(line);
  }
  return lines;
}

using Lines = std::vector<std::string>;

TEST(Gait, AcceptsAnyFeetWithGivenStarts) {
  const std::string gait =
      "type: trot, period: 0.4, dt: 0.02, feet: {A: LF, B: RF, C: LH}, starts: {A: 0, B: 0.5, C: "
      "0}";
  const Loaded loaded(with_gait(gait));
  ASSERT_TRUE(loaded.spec) << loaded.all();
  EXPECT_EQ(schedule(loaded), (Lines{"10: LF RF LH", "10: RF", "10: LF LH", "10: LF RF LH"}));
  const Loaded unsaid(with_gait(replaced(gait, ", C: 0}", "}")));
  EXPECT_FALSE(unsaid.spec);
  EXPECT_NE(unsaid.all().find("a trot of 3 feet is not known"), std::string::npos);
  EXPECT_NE(unsaid.all().find("starts: {...}"), std::string::npos);
}

TEST(Gait, TrotLiftsDiagonalPairsInTurn) {
  const Loaded loaded(with_gait("type: trot, cycles: 2, period: 0.4, dt: 0.02"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(schedule(loaded), (Lines{"10: LF RF LH RH", "10: LF RH", "10: RF LH", "10: LF RH",
                                     "10: RF LH", "10: LF RF LH RH"}));
}

TEST(Gait, PhasesNameTheirDurationKey) {
  const Loaded loaded(
      with_gait("type: trot, period: 0.4, dt: 0.02, stand: {begin: 0.3, end: 0.1}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<PhaseSpec>& phases = loaded.spec->phases;
  EXPECT_EQ(phases.front().knots.place.path, "gait.stand.begin");
  EXPECT_EQ(phases[1].knots.place.path, "gait.period");
  EXPECT_EQ(phases.back().knots.place.path, "gait.stand.end");
}

TEST(Gait, TypesLiftTheirFeetTogether) {
  const std::pair<const char*, Lines> cases[] = {
      {"type: stand, dt: 0.02", {"20: LF RF LH RH"}},
      {"type: pace, period: 0.4, dt: 0.02",
       {"10: LF RF LH RH", "10: LF LH", "10: RF RH", "10: LF RF LH RH"}},
      {"type: bound, period: 0.4, dt: 0.02",
       {"10: LF RF LH RH", "10: LH RH", "10: LF RF", "10: LF RF LH RH"}},
      {"type: bound, period: 0.4, dt: 0.02, duty: 0.4",
       {"10: LF RF LH RH", "10: LH RH", "2:", "10: LF RF", "10: LF RF LH RH"}},
      {"type: jump, period: 0.4, dt: 0.02, duty: 0.4, cycles: 2",
       {"10: LF RF LH RH", "12:", "8: LF RF LH RH", "12:", "10: LF RF LH RH"}},
      {"type: walk, period: 0.8, dt: 0.02",
       {"10: LF RF LH RH", "10: LF RF RH", "10: RF LH RH", "10: LF RF LH", "10: LF LH RH",
        "10: LF RF LH RH"}},
      {"type: walk, period: 0.8, dt: 0.02, duty: 0.85, stand: {begin: 0.1, end: 0.04}",
       {"5: LF RF LH RH", "6: LF RF RH", "4: LF RF LH RH", "6: RF LH RH", "4: LF RF LH RH",
        "6: LF RF LH", "4: LF RF LH RH", "6: LF LH RH", "2: LF RF LH RH"}},
      {"type: trot, period: 0.4, dt: 0.02, starts: {LH: 0.1}, stand: {begin: 0, end: 0.02}",
       {"2: LF LH RH", "8: LF RH", "2: RF", "8: RF LH", "1: LF RF LH RH"}},
  };
  for (const auto& [gait, expected] : cases) {
    const Loaded loaded(with_gait(gait));
    ASSERT_TRUE(loaded.built) << gait << loaded.all();
    EXPECT_EQ(schedule(loaded), expected) << gait;
  }
}

TEST(Gait, ImpulsesActOnLandingAndStandingFeet) {
  const Loaded trot(with_gait("type: trot, period: 0.4, dt: 0.02, duty: 0.6, impulses: true"));
  ASSERT_TRUE(trot.built) << trot.all();
  EXPECT_EQ(schedule(trot), (Lines{"10: LF RF LH RH", "8: LF RH", "! LF RF LH RH", "2: LF RF LH RH",
                                   "8: RF LH", "! LF RF LH RH", "10: LF RF LH RH"}));
  const Loaded bound(with_gait("type: bound, period: 0.4, dt: 0.02, impulses: true"));
  ASSERT_TRUE(bound.built) << bound.all();
  EXPECT_EQ(schedule(bound), (Lines{"10: LF RF LH RH", "10: LH RH", "! LF RF", "10: LF RF",
                                    "! LF RF LH RH", "10: LF RF LH RH"}));
}

TEST(Gait, SwingContinuesThroughImpulsesOfOtherFeet) {
  const Loaded loaded(
      with_gait("type: trot, period: 0.4, dt: 0.02, duty: 0.3, impulses: true, cycles: 2"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const CostSpec& cost : loaded.spec->costs) {
    if (!swing_of(cost)) continue;
    for (std::size_t p = 0; p < loaded.spec->phases.size(); ++p) {
      const PhaseSpec& phase = loaded.spec->phases[p];
      const bool held =
          std::any_of(phase.contacts.names.begin(), phase.contacts.names.end(),
                      [&](const Name& name) { return "swing_" + name.value == cost.name.value; });
      const bool swings = std::any_of(cost.phases->begin(), cost.phases->end(),
                                      [&](const Name& n) { return n.value == phase.name.value; });
      EXPECT_EQ(swings, !held) << cost.name.value << " in " << phase.name.value;
    }
    EXPECT_EQ(swing_of(cost)->displaced.size(), 2u);
  }
}

TEST(Gait, TwoFeetWalkWithDoubleSupport) {
  const Loaded loaded(R"(conddp: 1
robot: {urdf: robots/biped.urdf, base: floating}
contacts: {left: {frame: l_sole, type: surface}, right: {frame: r_sole, type: surface}}
initial_state: {base: {position: [0, 0, 0.78]}}
gait: {type: walk, feet: {L: left, R: right}, cycles: 2, period: 1, dt: 0.05,
       step: {length: 0.2, turn: 0.3}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(schedule(loaded),
            (Lines{"4: left right", "8: right", "2: left right", "8: left", "2: left right",
                   "8: right", "2: left right", "8: left", "4: left right"}));
  // Soles rotate with the robot.
  const CostSpec& swing = loaded.spec->costs.front();
  EXPECT_EQ(swing.definition, find_residual("frame_placement"));
  EXPECT_NEAR(swing_of(swing)->displaced.back().yaw, 0.6, 1e-12);
}

TEST(Gait, StepsSumToDistanceWithShortEnds) {
  const Loaded loaded(
      with_gait("type: trot, cycles: 4, period: 0.4, dt: 0.02, step: {length: 0.14}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const CostSpec& cost : loaded.spec->costs) {
    if (!swing_of(cost)) continue;
    const bool early = cost.name.value == "swing_RF" || cost.name.value == "swing_LH";
    double at = 0;
    for (int n = 0; n < 4; ++n) {
      const PlanarMotion& to = swing_of(cost)->displaced[n];
      const double full = 4 * 0.14 / 3.5;
      const bool half = early ? n == 0 : n == 3;
      EXPECT_NEAR(to.x - at, half ? full / 2 : full, 1e-11) << cost.name.value << n;
      EXPECT_EQ(to.y, 0);
      at = to.x;
    }
    EXPECT_NEAR(at, 4 * 0.14, 1e-11);
  }
}

TEST(Gait, OneCycleMovesEveryFootTheWholeWay) {
  const Loaded loaded(with_gait("type: walk, period: 0.8, dt: 0.02, step: {length: 0.16}"));
  for (const CostSpec& cost : loaded.spec->costs)
    if (swing_of(cost)) {
      EXPECT_NEAR(swing_of(cost)->displaced.at(0).x, 0.16, 1e-12);
    }
}

/// Parameters of a cost at a running knot, without its weight.
std::vector<double> reference_at(const ShootingProblem& problem, int k, const std::string& cost) {
  const KnotView& knot = problem.knot(k);
  for (const CostTerm& term : knot.model->costs())
    if (term.name == cost)
      return {knot.parameters + term.parameters, knot.parameters + term.weight};
  return {};
}

TEST(Gait, FeetLandOnTheDisplacedStance) {
  // Stance and footholds are computed in two ways: by kinematics of the displaced state, and by
  // displacing the feet.
  for (const char* gait :
       {"type: trot, cycles: 3, period: 0.4, dt: 0.02, step: {length: 0.2, direction: 0.7, turn: "
        "0.5}",
        "type: pace, period: 0.4, dt: 0.02, step: {length: 0.1, turn: -1}",
        "type: jump, cycles: 2, period: 0.4, dt: 0.02, step: {length: 0.3, direction: -2}"}) {
    const Loaded loaded(with_gait(gait));
    ASSERT_TRUE(loaded.built) << loaded.all();
    const ShootingProblem& problem = *loaded.built->problem;
    const MultibodySystem& system = *loaded.built->plant.multibody();
    const KnotView& last = problem.knot(problem.knots());
    const std::vector<double> state(last.parameters, last.parameters + problem.nx());
    const double moved = std::hypot(state[0] - 0.3, state[1] + 0.2);
    EXPECT_GT(moved, 0.05);
    for (const ContactSpec& contact : loaded.spec->contacts) {
      const int frame = *system.robot().find_frame(contact.frame.value);
      const Vector3<double> stance = placement_in_state(system, state, frame).p;
      std::vector<double> landed;
      for (int k = 0; k < problem.knots(); ++k)
        if (auto value = reference_at(problem, k, "swing_" + contact.name.value); !value.empty())
          landed = value;
      ASSERT_EQ(landed.size(), 3u);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(landed[i], stance[i], 1e-9) << contact.name.value;
    }
  }
}

TEST(Gait, ArcMatchesEvenMotion) {
  // Many small steps, each along the current base heading.
  const Loaded loaded(with_gait(
      "type: jump, period: 0.4, dt: 0.02, step: {length: 0.8, direction: 0.3, turn: 1.2}"));
  double x = 0, y = 0, yaw = 0;
  const int pieces = 100'000;
  for (int i = 0; i < pieces; ++i) {
    const double heading = yaw + 0.3 + 0.6 / pieces;
    x += 0.8 / pieces * std::cos(heading);
    y += 0.8 / pieces * std::sin(heading);
    yaw += 1.2 / pieces;
  }
  const PlanarMotion& end = swing_of(loaded.spec->costs[1])->displaced.at(0);
  EXPECT_NEAR(end.x, x, 1e-9);
  EXPECT_NEAR(end.y, y, 1e-9);
  EXPECT_NEAR(end.yaw, yaw, 1e-9);
}

/// Footholds of the swings of a foot, and the final base pose.
std::vector<PlanarMotion> landings(const Loaded& loaded, const std::string& foot) {
  std::vector<PlanarMotion> all;
  for (const CostSpec& cost : loaded.spec->costs)
    if (cost.name.value == "swing_" + foot) all = swing_of(cost)->displaced;
  all.push_back(loaded.spec->terminal_costs[0].reference->values[0].state->displaced->motion);
  return all;
}

// The base moves from 0.3 s to 0.9 s and covers a cycle's distance in 0.3 s.
TEST(Gait, CommandAtStartMatchesAnEqualStep) {
  const std::string trot = "type: trot, cycles: 2, period: 0.4, dt: 0.02, ";
  const Loaded step(with_gait(trot + "step: {length: 0.15, turn: 0.3}"));
  const Loaded led(with_gait(trot + "commands: [{at: 0, velocity: [0.5, 0, 0], turn: 1}]"));
  ASSERT_TRUE(step.built && led.built) << led.all();
  for (const char* foot : {"LF", "RF", "LH", "RH"}) {
    const auto a = landings(step, foot), b = landings(led, foot);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_NEAR(a[i].x, b[i].x, 1e-11) << foot << i;
      EXPECT_NEAR(a[i].y, b[i].y, 1e-11) << foot << i;
      EXPECT_NEAR(a[i].yaw, b[i].yaw, 1e-11) << foot << i;
    }
  }
}

TEST(Gait, CommandStartsFromTheBaseAtItsTime) {
  for (const char* gait : {"type: trot, cycles: 2, period: 0.4, dt: 0.02, ",
                           "type: trot, cycles: 2, period: 0.4, dt: 0.02, impulses: true, "}) {
    const Loaded led(with_gait(std::string(gait) +
                               "commands: [{at: 0, velocity: [0.5, 0, 0]}, {at: 0.6, velocity: [0, "
                               "0.2, 0]}]"));
    ASSERT_TRUE(led.built) << led.all();
    const PlanarMotion end = landings(led, "LF").back();
    EXPECT_NEAR(end.x, 0.5 * 0.3, 1e-11);
    EXPECT_NEAR(end.y, 0.2 * 0.3, 1e-11);
  }
  // A jump moves only during its swings, by the velocity times a whole period.
  const Loaded jump(
      with_gait("type: jump, cycles: 2, period: 0.4, dt: 0.02, commands: [{at: 0, "
                "velocity: [0.5, 0, 0]}, {at: 0.6, turn: 0.5}]"));
  ASSERT_TRUE(jump.built) << jump.all();
  const PlanarMotion end = landings(jump, "LF").back();
  EXPECT_NEAR(end.x, 0.5 * 0.4, 1e-11);
  EXPECT_NEAR(end.yaw, 0.5 * 0.4, 1e-11);
}

TEST(Gait, MotionBeforeACommandIgnoresIt) {
  const std::string trot = "type: trot, cycles: 4, period: 0.4, dt: 0.02, ";
  const Loaded one(with_gait(trot + "commands: [{at: 0, velocity: [0.3, 0, 0]}]"));
  const Loaded two(with_gait(trot +
                             "commands: [{at: 0, velocity: [0.3, 0, 0]}, {at: 1, velocity: [0.3, "
                             "0, 0], turn: 0.5}]"));
  ASSERT_TRUE(one.built && two.built) << two.all();
  for (int k = 0; k < one.built->problem->knots(); ++k) {
    const auto a = reference_at(*one.built->problem, k, "posture");
    const auto b = reference_at(*two.built->problem, k, "posture");
    double difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      difference = std::max(difference, std::abs(a[i] - b[i]));
    if (k <= 50) {
      EXPECT_LT(difference, 1e-9) << k;
    } else if (k > 51) {
      EXPECT_GT(difference, 1e-4) << k;
    }
  }
}

TEST(Gait, LandingsStayOnASlope) {
  const Loaded loaded(replaced(with_gait("type: trot, period: 0.4, dt: 0.02, step: {length: 0.2}"),
                               "LF: {frame: lf_foot}",
                               "LF: {frame: lf_foot, normal: [-0.6, 0, 0.8]}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  std::vector<std::vector<double>> values;
  for (int k = 0; k < problem.knots(); ++k)
    if (auto value = reference_at(problem, k, "swing_LF"); !value.empty()) values.push_back(value);
  const double advance = values.back()[0] - values.front()[0];
  EXPECT_NEAR(advance, 0.2 * std::cos(0.5), 1e-9);
  EXPECT_NEAR(values.back()[2] - values.front()[2], 0.75 * advance, 1e-9);
}

TEST(Gait, BaseMovesEvenlyBetweenFirstAndLastMidswing) {
  const Loaded loaded(
      with_gait("type: trot, cycles: 2, period: 0.4, dt: 0.02, step: {length: 0.15}"));
  const ReferenceSpec& way = *loaded.spec->costs[0].reference;
  ASSERT_EQ(way.knots.size(), 2u);
  EXPECT_EQ(way.knots[0].value, 15);
  EXPECT_EQ(way.knots[1].value, 45);
  const ShootingProblem& problem = *loaded.built->problem;
  const double c = std::cos(0.5), s = std::sin(0.5);
  for (const auto& [knot, gone] :
       {std::pair(0, 0.0), {15, 0.0}, {30, 0.15}, {45, 0.3}, {59, 0.3}}) {
    const std::vector<double> at = reference_at(problem, knot, "posture");
    EXPECT_NEAR(at[0], 0.3 + c * gone, 1e-12) << knot;
    EXPECT_NEAR(at[1], -0.2 + s * gone, 1e-12) << knot;
  }
}

TEST(Gait, ExpandedFileIsBitwiseTheSameProblem) {
  for (const char* gait :
       {"type: trot, cycles: 3, period: 0.44, dt: 0.02, step: {length: 0.13, turn: 0.37}",
        "type: bound, cycles: 2, period: 0.4, dt: 0.01, duty: 0.3, impulses: true, step: "
        "{length: 0.21}"}) {
    const Loaded first(with_gait(gait));
    ASSERT_TRUE(first.built) << first.all();
    const std::string text = expanded_text(*first.built);
    EXPECT_EQ(text.find("gait"), std::string::npos) << text;
    const Loaded second(text);
    ASSERT_TRUE(second.built) << second.all();
    const auto& a = *first.built->problem;
    const auto& b = *second.built->problem;
    ASSERT_EQ(a.phases().size(), b.phases().size());
    for (std::size_t p = 0; p < a.phases().size(); ++p) {
      EXPECT_EQ(a.phases()[p].name, b.phases()[p].name);
      EXPECT_EQ(a.phases()[p].dt, b.phases()[p].dt);
      EXPECT_EQ(a.phases()[p].cost_scale, b.phases()[p].cost_scale);
      EXPECT_EQ(a.phases()[p].parameters, b.phases()[p].parameters);
      EXPECT_EQ(a.phases()[p].model->costs().size(), b.phases()[p].model->costs().size());
    }
    EXPECT_EQ(a.terminal().parameters, b.terminal().parameters);
  }
}

TEST(GaitFile, DefaultsMatchTheSchema) {
  const Json schema = load_schema()["definitions"]["gait"]["properties"];
  const auto value = [&](const Json& part, const char* key) {
    return part.at(key).at("default").dump();
  };
  const Json& step = schema["step"]["properties"];
  const Json& stand = schema["stand"]["properties"];
  const std::string said = fmt::format(
      "type: trot, period: 0.4, dt: 0.02, cycles: {}, impulses: {}, weight: {}, duty: 0.5, "
      "stand: {{begin: {}, end: {}}}, step: {{length: {}, height: {}, direction: {}, turn: {}}}, "
      "feet: {{LF: LF, RF: RF, LH: LH, RH: RH}}, starts: {{LF: 0.5, RF: 0, LH: 0, RH: 0.5}}",
      value(schema, "cycles"), value(schema, "impulses"), value(schema, "weight"),
      value(stand, "begin"), value(stand, "end"), value(step, "length"), value(step, "height"),
      value(step, "direction"), value(step, "turn"));
  const Loaded all(with_gait(said)), none(kQuadruped);
  ASSERT_TRUE(all.built) << all.all();
  ASSERT_TRUE(none.built) << none.all();
  EXPECT_EQ(expanded_text(*all.built), expanded_text(*none.built));
}

TEST(GaitFile, FreeDurationsAreSharesOfEachPhase) {
  const std::string gait = "type: trot, period: 0.4, dt: 0.02, impulses: true, free_durations: ";
  const Loaded loaded(with_gait(gait + "{lower: 0.75, upper: 1.5}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  ASSERT_TRUE(loaded.spec->phases.front().choice);
  int free = 0;
  for (const PhaseSpec& phase : loaded.spec->phases) {
    EXPECT_EQ(phase.free_duration.has_value(), !phase.takes_no_time()) << phase.name.value;
    if (!phase.free_duration) continue;
    const double duration = phase.knots.value * phase.dt;
    EXPECT_NEAR(phase.free_duration->lower, 0.75 * duration, 1e-12);
    EXPECT_NEAR(phase.free_duration->upper, 1.5 * duration, 1e-12);
    ++free;
  }
  EXPECT_EQ(free, 4);
  // Numbers of knots count from the gait's first phase.
  EXPECT_EQ(loaded.spec->gait_way.front().node, 1 + 10 + 5);
  EXPECT_TRUE(Loaded(with_gait(gait + "{}")).built);
  const Loaded wrong(with_gait(gait + "{lower: 1.2}"));
  EXPECT_NE(wrong.first_error().find("a share from 0 (excluded) to 1"), std::string::npos)
      << wrong.first_error();
}

TEST(GaitFile, ReportsMistakesAtTheirPlaces) {
  struct Case {
    const char* gait;
    const char* says;
  };
  const Case cases[] = {
      {"type: gallop, dt: 0.02", "13:14: unknown gait 'gallop'"},
      {"type: trot, dt: 0.02", "13:7: 'gait' lacks the key 'period'"},
      {"type: trot, period: 0.4", "13:7: 'gait' lacks the key 'dt'"},
      {"type: trot, period: 0.41, dt: 0.02",
       "13:28: the period 0.41 s is 20.5 times dt, 0.02 s: it must be a whole number of steps"},
      {"type: trot, period: 0.4, dt: 0.02, stand: {begin: 0.03}",
       "13:58: standing before the gait 0.03 s is 1.5 times dt"},
      {"type: trot, period: 0.4, dt: 0.02, stand: {end: 0}",
       "13:56: the feet touch down at the beginning of the stand at the end: it needs one step"},
      {"type: trot, period: 0.4, dt: 0.02, duty: 1",
       "13:49: with a duty of 1 no foot ever lifts: it would be in the air for 0 s"},
      {"type: trot, period: 0.4, dt: 0.02, duty: 0.98",
       "13:49: with a duty of 0.98 no foot ever lifts: it would be in the air for 0.008 s"},
      {"type: trot, period: 0.4, dt: 0.02, duty: 0.01",
       "13:49: with a duty of 0.01 no foot ever stands: that would be for 0.004 s"},
      {"type: trot, period: 0.4, dt: 0.02, duty: 1.2",
       "13:49: a share of the cycle from 0 (excluded) to 1 is expected here"},
      {"type: trot, period: 0.4, dt: 0.02, commands: [{at: 0, velocity: [1, 0, 1]}]",
       "13:72: a command leads in the plane: its third velocity is 0"},
      {"type: trot, period: 0.4, dt: 0.02, commands: [{at: 0, velocity: [1e300, 0, 0]}]",
       "13:72: a command leads with at most 1000 m/s in each direction"},
      {"type: trot, period: 0.4, dt: 0.02, commands: [{at: 0, turn: -1e4}]",
       "13:68: a number from -1000 to 1000 is expected here"},
      {"type: trot, period: 0.4, dt: 0.02, commands: [{at: 50}]",
       "13:59: the gait has ended by then"},
      {"type: trot, period: 0.4, dt: 0.02, commands: [{at: 1}, {at: 1}]",
       "13:68: commands stand in the order of their times"},
      {"type: stand, dt: 0.02, commands: [{at: 1}]",
       "13:41: standing feet make no steps: the gait 'stand' has no 'commands'"},
      {"type: trot, period: 0.4, dt: 0.02, cycles: 0",
       "13:51: a whole number from 1 to 10000 is expected here"},
      {"type: trot, period: 400, dt: 0.001, cycles: 4", "13:7: the gait has more than 1000000"},
      {"type: trot, period: 1e9, dt: 0.02", "13:28: the period 1000000000 s is more than 1000000"},
      {"type: trot, period: 0.4, dt: 0.02, feet: {LF: LF, RF: RF, LH: LH, RH: HR}",
       "13:78: unknown contact 'HR'"},
      {"type: trot, period: 0.4, dt: 0.02, feet: {LF: LF, RF: RF, LH: LH, RH: LH}",
       "13:78: the contact 'LH' is the foot 'LH' already"},
      {"type: trot, period: 0.4, dt: 0.02, feet: {LF: LF, RF: RF, LB: LH, RH: RH}",
       "13:66: a trot has no foot 'LB'"},
      {"type: trot, period: 0.4, dt: 0.02, feet: {LF: LF, RF: RF}",
       "13:49: a trot of 2 feet is not known"},
      {"type: trot, period: 0.4, dt: 0.02, starts: {L: 0.3}", "13:52: the gait has no foot 'L'"},
      {"type: trot, period: 0.4, dt: 0.02, starts: {LF: 1}",
       "13:56: a share of the cycle from 0 to 1 (excluded) is expected here"},
      {"type: stand, period: 0.4, dt: 0.02",
       "13:29: standing feet make no steps: the gait 'stand' has no 'period'"},
      {"type: stand, dt: 0.02, stand: {begin: 0, end: 0}", "13:7: the gait takes no time"},
      {"type: trot, period: 0.4, dt: 0.02, step: {turn: 4}",
       "13:56: an angle from -π to π is expected here"},
      {"type: trot, period: 0.4, dt: 0.02, impulses: 1", "13:53: unknown value of 'impulses' '1'"},
  };
  for (const Case& c : cases) {
    const Loaded loaded(with_gait(c.gait));
    EXPECT_FALSE(loaded.built) << c.gait;
    EXPECT_TRUE(loaded.first_error().starts_with(c.says)) << c.gait << '\n' << loaded.all();
  }
}

TEST(GaitFile, RejectsIncompatibleFeatures) {
  const std::string trot = with_gait("type: trot, period: 0.4, dt: 0.02");
  const std::pair<std::string, const char*> cases[] = {
      {replaced(trot, "costs:", "phases: [{knots: 2, dt: 0.1}]\ncosts:"),
       "14:1: 'gait' and 'phases' exclude each other"},
      {replaced(trot, "contacts: {LF: {frame: lf_foot}, ", "contacts: {FL: {frame: lf_foot}, "),
       "13:7: it is not clear which contacts are the feet"},
      {replaced(trot, "posture: {residual: state", "swing_LF: {residual: state"),
       "15:3: the gait makes a cost 'swing_LF' for the swings of 'LF'"},
      {replaced(trot, "initial_state: {configuration: standing}",
                "initial_state: {configuration: standing, displaced: gait}"),
       "12:53: 'gait' is the path of the file's gait"},
      {replaced(trot, "displaced: gait}}\nterminal", "displaced: gate}}\nterminal"),
       "15:78: a list of 3 numbers, [x, y, yaw] in m and rad, is expected here"},
      {replaced(trot, "base: floating", "base: fixed"), "7:13: the robot's base is fixed"},
      {std::string(kPendulum) + "gait: {type: jump, period: 1, dt: 0.1}\n",
       "17:1: 'phases' and 'gait' exclude each other"}};
  for (const auto& [text, says] : cases) {
    const Loaded loaded(text);
    EXPECT_FALSE(loaded.built) << text;
    EXPECT_TRUE(loaded.first_error().starts_with(says)) << says << '\n' << loaded.all();
  }
}

TEST(Displacement, MovesAndTurnsABaseInItsAxes) {
  const Loaded loaded(replaced(kQuadruped, "initial_state: {configuration: standing}",
                               "initial_state: {configuration: standing, displaced: [1, 2, 0.3]}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double>& x = loaded.built->problem->initial_state();
  EXPECT_NEAR(x[0], 0.3 + std::cos(0.5) - 2 * std::sin(0.5), 1e-12);
  EXPECT_NEAR(x[1], -0.2 + std::sin(0.5) + 2 * std::cos(0.5), 1e-12);
  EXPECT_NEAR(x[2], 0.57, 1e-12);
  EXPECT_NEAR(x[5], std::sin(0.4), 1e-12);
  EXPECT_NEAR(x[6], std::cos(0.4), 1e-12);
}

TEST(Displacement, PlanarBaseRotatesItsVelocity) {
  const Loaded loaded(R"(conddp: 1
robot: {urdf: robots/hopper.urdf, base: planar}
initial_state: {base: {position: [1, 2]}, joints: {base_yaw: 0.5}, displaced: [0.1, 0, 1.0],
                velocity: {base: {linear: [3, 0, 0]}}}
phases: [{knots: 2, dt: 0.1}]
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double>& x = loaded.built->problem->initial_state();
  EXPECT_NEAR(x[0], 1 + 0.1 * std::cos(0.5), 1e-12);
  EXPECT_NEAR(x[1], 2 + 0.1 * std::sin(0.5), 1e-12);
  EXPECT_NEAR(x[2], 1.5, 1e-12);
  const int nq = loaded.built->plant.multibody()->nq();
  EXPECT_NEAR(x[nq], 3 * std::cos(1.0), 1e-12);
  EXPECT_NEAR(x[nq + 1], 3 * std::sin(1.0), 1e-12);
}

}  // namespace
}  // namespace conddp
