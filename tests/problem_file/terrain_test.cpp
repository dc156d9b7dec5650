// Gaits on a terrain: footholds, swings, the base's path, contact normals, warnings and errors.
#include "problem_file/motion/terrain.hpp"

#include <cmath>

#include <fmt/format.h>

#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/plant/shape_pairs.hpp"
#include "problem_text.hpp"
#include "robot/frames.hpp"
#include "robot/kinematics.hpp"

namespace conddp {
namespace {

/// A trot of two cycles with footholds 0.2 m apart; RF lands 0.1, 0.3 m further on, LF 0.2, 0.3 m.
const std::string kTrot = R"(conddp: 1
robot:
  urdf: robots/quadruped.urdf
  base: floating
  configurations:
    standing:
      base: {position: [0, 0, 0.57]}
      joints: {"*_HAA": -0.2, "*F_HFE": 0.75, "*F_KFE": -1.5, "*H_HFE": -0.75, "*H_KFE": 1.5}
contacts: {LF: {frame: lf_foot}, RF: {frame: rf_foot}, LH: {frame: lh_foot}, RH: {frame: rh_foot}}
terrain:
  ground: {half_space: {}}
  step: {box: {size: [2, 2, 0.1], placement: {position: [1.5, 0, 0.05]}}}
initial_state: {configuration: standing}
gait: {type: trot, cycles: 2, period: 0.4, dt: 0.02, step: {length: 0.15, height: 0.06}}
costs:
  posture: {residual: state, reference: {configuration: standing, displaced: gait}}
  cone: {residual: friction_cone}
terminal:
  costs:
    rest: {residual: state, reference: {configuration: standing, displaced: gait}}
)";

const std::string kStep = "step: {box: {size: [2, 2, 0.1], placement: {position: [1.5, 0, 0.05]}}}";

std::string on(const std::string& pieces) { return replaced(kTrot, kStep, pieces); }

/// References of a cost at the running knots that have it.
std::vector<std::vector<double>> references(const Loaded& loaded, const std::string& cost) {
  std::vector<std::vector<double>> all;
  const ShootingProblem& problem = *loaded.built->problem;
  for (int k = 0; k < problem.knots(); ++k)
    for (const CostTerm& term : problem.knot(k).model->costs())
      if (const double* p = problem.knot(k).parameters; term.name == cost && p[term.weight] != 0)
        all.emplace_back(p + term.parameters, p + term.weight);
  return all;
}

double height_at(const Loaded& loaded, double x, double y) {
  return ground_at(loaded.spec->terrain, x, y).value().height;
}

TEST(Terrain, HeightIsThatOfTheHighestPiece) {
  const Loaded loaded(on(kStep + "\n  slope: {half_space: {normal: [-0.6, 0, 0.8], point: [3, 0, "
                                 "0]}}\n  tilted: {box: {size: [0.2, 0.2, 0.2], placement: "
                                 "{position: [-1, 0, 0], rpy: [0, 0.7853981633974483, 0]}}}"));
  ASSERT_TRUE(loaded.spec) << loaded.all();
  EXPECT_NEAR(height_at(loaded, 0.4, 0), 0, 1e-12);
  EXPECT_NEAR(height_at(loaded, 0.6, 0), 0.1, 1e-12);
  EXPECT_NEAR(height_at(loaded, 3.4, 0), 0.3, 1e-12);
  // The edge of the tilted box, and a point on its forward face.
  EXPECT_NEAR(height_at(loaded, -1, 0), 0.1 * std::sqrt(2), 1e-12);
  const Ground face = *ground_at(loaded.spec->terrain, -0.95, 0);
  EXPECT_NEAR(face.height, 0.1 * std::sqrt(2) - 0.05, 1e-12);
  EXPECT_NEAR(face.normal.x, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(face.normal.z, std::sqrt(0.5), 1e-12);
}

TEST(Terrain, FootholdsLieOnSteps) {
  const Loaded loaded(kTrot);
  ASSERT_TRUE(loaded.built) << loaded.all();
  // RF stands at x = 0.35, and 0.02 mm above the ground.
  const std::vector<double> last = references(loaded, "swing_RF").back();
  EXPECT_NEAR(last[0], 0.65, 1e-4);
  EXPECT_NEAR(last[2], 0.1, 1e-4);
}

TEST(Terrain, SwingsClearAStepAsLevelGround) {
  const Loaded loaded(kTrot);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto swing = references(loaded, "swing_RF");
  double highest = 0;
  for (const auto& value : swing) {
    EXPECT_GT(value[2] - height_at(loaded, value[0], value[1]), -1e-9) << value[0];
    highest = std::max(highest, value[2]);
  }
  // The middle of the second swing is above the step.
  EXPECT_GT(highest, 0.16 - 1e-9);
  EXPECT_LT(highest, 0.3);
}

TEST(Terrain, BaseRisesByTheMeanOfItsFeet) {
  const Loaded loaded(kTrot);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto way = references(loaded, "posture");
  EXPECT_NEAR(way.front()[2], 0.57, 1e-12);
  // Both fore feet end on the step, both hind feet below it.
  EXPECT_NEAR(way.back()[2], 0.57 + 0.05, 1e-9);
  for (std::size_t i = 1; i < way.size(); ++i) EXPECT_GE(way[i][2], way[i - 1][2] - 1e-12);
  // Points of the path: its ends, and a landing of each pair between them.
  EXPECT_EQ(loaded.spec->costs[0].reference->knots.size(), 4u);
}

TEST(Terrain, LevelGroundIsBitwiseNoTerrain) {
  const Loaded level(on("")), none(replaced(on(""), "terrain:\n  ground: {half_space: {}}\n", ""));
  ASSERT_TRUE(level.built && none.built) << level.all();
  for (const char* cost : {"swing_LF", "swing_RH"})
    EXPECT_EQ(references(level, cost), references(none, cost));
}

TEST(Terrain, SlopeTurnsNormalsOfSteppingContacts) {
  const Loaded loaded(replaced(on("hill: {half_space: {normal: [-0.6, 0, 0.8], point: [0.5, 0, "
                                  "0]}}"),
                               "RH: {frame: rh_foot}", "RH: {frame: rh_foot}, T: {frame: trunk}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto normal_of = [&](int knot, const std::string& name) {
    const auto* system = loaded.built->problem->knot(knot).model->system().robot_inside();
    for (const Contact& contact : system->contacts().contacts())
      if (contact.name == name) return contact.normal;
    return Vector3<double>::zero();
  };
  const int last = loaded.built->problem->knots() - 1;
  EXPECT_EQ(normal_of(0, "RF").z, 1);
  EXPECT_NEAR(normal_of(last, "RF").x, -0.6, 1e-12);
  EXPECT_NEAR(normal_of(last, "RF").z, 0.8, 1e-12);
  EXPECT_EQ(normal_of(last, "LH").z, 1);
}

TEST(Terrain, SolesTiltWithTheirFootholds) {
  const Loaded loaded(R"(conddp: 1
robot: {urdf: robots/biped.urdf, base: floating}
contacts:
  defaults: {type: surface, size: [0.18, 0.08], baumgarte: {kp: 100}}
  L: {frame: l_sole}
  R: {frame: r_sole}
terrain: {ground: {half_space: {}}, ramp: {half_space: {normal: [-0.28, 0, 0.96], point: [0.1, 0, 0]}}}
initial_state: {base: {position: [0, 0, 0.84]}}
gait: {type: walk, cycles: 2, period: 1, dt: 0.05, step: {length: 0.3, height: 0.05}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double> pose = references(loaded, "swing_L").back();
  const Matrix3<double> R = rotation_matrix(Quaternion<double>{pose[3], pose[4], pose[5], pose[6]});
  EXPECT_NEAR(R.column(2).x, -0.28, 1e-12);
  EXPECT_NEAR(R.column(2).z, 0.96, 1e-12);
  EXPECT_NEAR(pose[2], (pose[0] - 0.1) * 0.28 / 0.96, 1e-9);
  // Stabilization draws the sole to the same pose.
  const ShootingProblem& problem = *loaded.built->problem;
  const auto* system = problem.knot(problem.knots() - 1).model->system().robot_inside();
  const Contact& left = system->contacts().contacts().front();
  EXPECT_NEAR(left.reference.R.column(2).x, -0.28, 1e-12);
  EXPECT_NEAR(left.reference.p.z, pose[2], 1e-12);
}

TEST(Terrain, ExpandedFileIsTheSameProblem) {
  const Loaded first(kTrot);
  ASSERT_TRUE(first.built) << first.all();
  const Loaded second(expanded_text(*first.built));
  ASSERT_TRUE(second.built) << second.all();
  const auto &a = first.built->problem->phases(), &b = second.built->problem->phases();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t p = 0; p < a.size(); ++p) EXPECT_EQ(a[p].parameters, b[p].parameters);
}

TEST(Terrain, DisplacementsMayRise) {
  const Loaded loaded(replaced(replaced(on(""), "terrain:\n  ground: {half_space: {}}\n", ""),
                               "initial_state: {configuration: standing}",
                               "initial_state: {configuration: standing, displaced: [0.2, 0, 0, "
                               "0.3]}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NEAR(loaded.built->problem->initial_state()[0], 0.2, 1e-12);
  EXPECT_NEAR(loaded.built->problem->initial_state()[2], 0.87, 1e-12);
}

TEST(Terrain, RobotWithMistakesIsReportedAsWithout) {
  const std::string text = replaced(on(""), "\"*F_HFE\": 0.75", "knob: 0.75");
  const Loaded with(text), without(replaced(text, "terrain:\n  ground: {half_space: {}}\n", ""));
  EXPECT_FALSE(with.built);
  EXPECT_EQ(with.diagnostics.error_count(), without.diagnostics.error_count()) << with.all();
}

TEST(Terrain, SimulatedContactsTouchItsShapes) {
  const std::string loop = kTrot +
                           "mpc: {horizon: 0.4, tick: 0.02, duration: 1, plant: {dt: "
                           "0.002, contacts: simulated}}\n";
  const Loaded loaded(loop), own(replaced(loop, "dt: 0.002", "dt: 0.002, ground: [ground]"));
  ASSERT_TRUE(loaded.spec && own.spec) << loaded.all() << own.all();
  const std::vector<TouchedSpec>& ground = loaded.spec->mpc->plant.ground;
  ASSERT_EQ(ground.size(), 2u);
  EXPECT_EQ(std::get<BoxSpec>(ground[1].form).size.z, 0.1);
  EXPECT_EQ(own.spec->mpc->plant.ground.size(), 1u);
}

/// x of the first landing of a foot that begins at `from`, m.
double first_landing(const Loaded& loaded, const std::string& swing, double from) {
  double farthest = from;
  for (const auto& value : references(loaded, swing)) {
    if (value[0] < farthest) break;
    farthest = value[0];
    if (farthest > from + 0.01 && value[2] < 1e-3) break;
  }
  return farthest;
}

TEST(Terrain, FootholdsKeepOffEdges) {
  EXPECT_EQ(warnings(kTrot), "");
  // RF would land at x = 0.45, near the edge at 0.47.
  const Loaded near(on(replaced(kStep, "1.5, 0", "1.47, 0")));
  ASSERT_TRUE(near.built) << near.all();
  EXPECT_EQ(near.all().find("warning"), std::string::npos) << near.all();
  EXPECT_LE(first_landing(near, "swing_RF", 0.35), 0.44);
  EXPECT_GT(first_landing(near, "swing_RF", 0.35), 0.435);
  const Loaded level(kTrot);
  EXPECT_NEAR(first_landing(level, "swing_RF", 0.35), 0.45, 1e-4);
}

TEST(Terrain, WarnsOfFootholdsNearEdges) {
  // RF lands in the middle of a beam that is too narrow for it.
  const std::string near =
      warnings(on("beam: {box: {size: [0.04, 2, 0.1], placement: {position: [0.45, 0, 0.05]}}}"));
  EXPECT_NE(near.find("step 1 of 'rf_foot' to [0.450, "), std::string::npos) << near;
  EXPECT_NE(near.find("lands less than 0.03 m from an edge"), std::string::npos) << near;
  EXPECT_NE(near.find("change the length of the steps"), std::string::npos) << near;
}

const std::string kBipedWalk = R"(conddp: 1
robot: {urdf: robots/biped.urdf, base: floating}
contacts:
  defaults: {type: surface, size: [0.18, 0.08]}
  L: {frame: l_sole}
  R: {frame: r_sole}
terrain: {ground: {half_space: {}}}
initial_state: {base: {position: [0, 0, 0.84]}}
gait: {type: walk, cycles: 1, period: 1, dt: 0.05, step: {length: 0.45, height: 0.05}}
)";

/// x of the last landing of the left foot, m.
double left_landing(const Loaded& loaded) { return references(loaded, "swing_L").back()[0]; }

TEST(Terrain, SolesKeepOffEdges) {
  const double level = left_landing(Loaded(kBipedWalk));
  const auto with_edge = [&](double before) {
    return Loaded(replaced(
        kBipedWalk, "half_space: {}}",
        fmt::format(
            "half_space: {{}}}}, stair: {{box: {{size: [4, 4, 0.1], placement: {{position: [{}, 0, "
            "0]}}}}}}",
            level + before + 2)));
  };
  // The sole reaches 0.09 m forward.
  const Loaded over = with_edge(0.05);
  ASSERT_TRUE(over.built) << over.all();
  EXPECT_EQ(over.all().find("over an edge"), std::string::npos) << over.all();
  EXPECT_LE(left_landing(over), level - 0.04 + 1e-9);
  EXPECT_GT(left_landing(over), level - 0.055);
}

TEST(Terrain, WarnsOfOverhangingSoles) {
  const double level = left_landing(Loaded(kBipedWalk));
  const std::string said = warnings(replaced(
      kBipedWalk, "half_space: {}}",
      fmt::format(
          "half_space: {{}}}}, stone: {{box: {{size: [0.1, 2, 0.2], placement: {{position: [{}, 0, "
          "0]}}}}}}",
          level)));
  EXPECT_NE(said.find("where a corner of the sole is over an edge"), std::string::npos) << said;
}

TEST(Terrain, WarnsOfSwingsThroughTheTerrain) {
  // RF steps from x = 0.55 to 0.95, and reaches the edge at 0.585 soon.
  const std::string high = "step: {box: {size: [2, 2, 0.4], placement: {position: [1.585, 0, 0]}}}";
  const std::string said = warnings(replaced(on(high), "length: 0.15", "length: 0.3"));
  EXPECT_NE(said.find("passes through the terrain"), std::string::npos) << said;
}

TEST(Terrain, PairsNameItsBoxes) {
  const std::string text =
      kTrot + "collision: {shapes: {shin: {frame: lf_foot, sphere: {radius: 0.05}}}}\n";
  const std::string named =
      replaced(text, "costs:\n", "costs:\n  clear: {residual: distance, pairs: [[shin, step]]}\n");
  const Loaded loaded(named);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const CostSpec& cost = loaded.spec->costs.front();
  Diagnostics out;
  EXPECT_EQ(shape_pairs(cost, *loaded.spec, loaded.built->plant, out).size(), 1u);
  const Loaded all(replaced(named, "[[shin, step]]", "obstacles"));
  EXPECT_NE(all.all().find("has no pair of shapes"), std::string::npos) << all.all();
}

TEST(TerrainFile, ReportsMistakesAtTheirPlaces) {
  const std::pair<std::string, const char*> cases[] = {
      {replaced(kTrot, "ground: {half_space: {}}", "ground: {half_space: {normal: [0, 0, -1]}}"),
       "11:24: the normal of ground points upward"},
      {replaced(kTrot, "ground: {half_space: {}}", "ground: {}"), "11:11: the shape has no form"},
      {on(kStep + "\n  map: {height_map: {file: none.csv, cell: 0.1}}"),
       "none.csv' does not exist"},
      {on(kStep + "\n  map: {height_map: {cell: 0.1}}"), "lacks the key 'file'"},
      {replaced(kTrot, "ground: {half_space: {}}\n  ", ""),
       "13:7: the terrain has no ground for 'lf_foot' at [0.35, "},
      {on("board: {box: {size: [20, 4, 0.02], placement: {position: [0.35, 0, 0], rpy: [0, 1.55, "
          "0]}}}"),
       "the terrain is too steep (88.8°, "},
      {kTrot + "collision: {obstacles: {step: {sphere: {radius: 1}}}}\n",
       "two shapes have the name 'step'"},
      {std::string(kPendulum) + "terrain: {ground: {half_space: {}}}\n",
       "a closed-form system has no feet that could stand on it"}};
  for (const auto& [text, says] : cases)
    EXPECT_NE(Loaded(text).first_error().find(says), std::string::npos) << says << "\n"
                                                                        << Loaded(text).all();
}

}  // namespace
}  // namespace conddp
