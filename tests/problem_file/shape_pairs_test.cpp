// Pairs of shapes of a distance cost, and rejected selections.
#include "problem_file/plant/shape_pairs.hpp"

#include "problem_text.hpp"

namespace conddp {
namespace {

constexpr std::string_view kArm = R"(conddp: 1
robot: {urdf: robots/arm7.urdf}
collision:
  shapes:
    base: {frame: base, sphere: {radius: 0.1}}
    upper: {frame: link_3, capsule: {radius: 0.05, to: [0, 0, 0.2]}}
    elbow: {frame: link_3, sphere: {radius: 0.05}}
    middle: {frame: link_4, sphere: {radius: 0.05}}
    hand: {frame: tool, sphere: {radius: 0.05}}
  obstacles:
    ball: {sphere: {radius: 0.1, center: [0.5, 0, 0.5]}}
    floor: {half_space: {}}
initial_state: {joints: {joint_2: 0.3}}
phases: [{knots: 2, dt: 0.1}]
costs: {clear: {residual: distance, pairs: all}}
)";

using Names = std::vector<std::string>;

Names pairs_of(const char* choice) {
  const Loaded loaded(replaced(kArm, "pairs: all", std::string("pairs: ") + choice));
  EXPECT_TRUE(loaded.built) << loaded.all();
  Names names;
  if (!loaded.built) return names;
  Diagnostics out;
  for (const ShapePair& pair :
       shape_pairs(loaded.spec->costs[0], *loaded.spec, loaded.built->plant, out))
    names.push_back(pair.first + "-" + pair.second);
  return names;
}

TEST(ShapePairs, SelfPairsExcludeSameLinkAndNeighbours) {
  EXPECT_EQ(pairs_of("self"), (Names{"base-upper", "base-elbow", "base-middle", "base-hand",
                                     "upper-hand", "elbow-hand", "middle-hand"}));
}

TEST(ShapePairs, ObstaclePairsIncludeMovingShapesOnly) {
  EXPECT_EQ(pairs_of("obstacles"),
            (Names{"upper-ball", "upper-floor", "elbow-ball", "elbow-floor", "middle-ball",
                   "middle-floor", "hand-ball", "hand-floor"}));
  EXPECT_EQ(pairs_of("all").size(), 15u);
}

TEST(ShapePairs, NamedPairsMayBeNeighboursAndAppearOnce) {
  EXPECT_EQ(pairs_of("[[floor, hand], [hand, floor], [upper, middle]]"),
            (Names{"hand-floor", "upper-middle"}));
  EXPECT_EQ(pairs_of("[[elbow, '*']]"),
            (Names{"base-elbow", "elbow-middle", "elbow-hand", "elbow-ball", "elbow-floor"}));
}

void expect_error(const char* from, const char* to, const std::string& message) {
  const Loaded loaded(replaced(kArm, from, to));
  EXPECT_FALSE(loaded.built);
  EXPECT_NE(loaded.first_error().find(message), std::string::npos) << loaded.all();
}

TEST(ShapePairs, ImpossiblePairsAreRejectedWithPlaces) {
  expect_error("pairs: all", "pairs: [[hand, bell]]", "15:52: unknown shape 'bell'");
  expect_error("pairs: all", "pairs: [[upper, elbow]]",
               "15:46: 'upper' and 'elbow' do not move relative to each other");
  expect_error("pairs: all", "pairs: [[ball, floor]]", "do not move relative to each other");
  expect_error("pairs: all", "pairs: [[hand]]", "a pair has two names, this list 1");
  expect_error("pairs: all", "pairs: [hand, ball]", "a pair of shapes is expected here");
  expect_error("pairs: all", "pairs: []", "there is no pair");
  expect_error("pairs: all", "margin: 0.1", "'costs.clear' lacks the key 'pairs'");
  expect_error("pairs: all", "pairs: all, margin: 0.1, activation: quadratic",
               "'margin' and 'activation' exclude each other");
  expect_error("residual: distance, pairs: all", "residual: control, pairs: all",
               "the residual 'control' has no 'pairs'");
  expect_error("frame: link_4", "frame: link_44", "the robot has no frame 'link_44'");
  expect_error("ball: {sphere", "hand: {sphere", "a shape and an obstacle have the name 'hand'");
  expect_error("to: [0, 0, 0.2]", "to: [0, 0, 0]", "the capsule has length 0");
  expect_error("floor: {half_space: {}}", "floor: {}", "the shape has no form");
  expect_error("{half_space: {}}", "{half_space: {}, sphere: {radius: 1}}", "a shape is one thing");
  expect_error("{half_space: {}}", "{half_space: {normal: [0, 0, 0]}}", "a direction of length 0");
}

TEST(ShapePairs, NeedRobotsAndShapes) {
  const Loaded closed(std::string(kPendulum) + "collision: {obstacles: {f: {half_space: {}}}}\n");
  EXPECT_NE(closed.first_error().find("a closed-form system has no links"), std::string::npos);
  const Loaded none(
      replaced(kCartpole, "phases:", "costs: {c: {residual: distance, pairs: self}}\nphases:"));
  EXPECT_NE(none.first_error().find("the cost 'c' has no pair of shapes"), std::string::npos)
      << none.all();
}

TEST(Distance, CostsHalfTheSquaredMarginDeficit) {
  const Loaded loaded(replaced(kArm, "pairs: all", "pairs: [[hand, floor]], margin: 2, weight: 3"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto& problem = *loaded.built->problem;
  const KnotModel& model = *problem.knot(0).model;
  KnotWorkspace<double> work(model);
  const Trajectory& guess = loaded.built->guess;
  model.evaluate(
      KnotInput<double>{guess.x(0).data(), guess.u(0).data(), problem.knot(0).parameters, 0.1, 1.0},
      work);
  const Plant& plant = loaded.built->plant;
  const int tool = *plant.robot().find_frame("tool");
  const double height =
      placement_in_state(*plant.multibody(), problem.initial_state(), tool).p.z - 0.05;
  EXPECT_NEAR(work.cost, 0.5 * 3 * (2 - height) * (2 - height), 1e-12);
}

TEST(Joints, CostJointsMayBePatterns) {
  const auto rows = [](const char* joints) {
    const Loaded loaded(replaced(kArm, "residual: distance, pairs: all",
                                 std::string("residual: joint_position, joints: ") + joints));
    EXPECT_TRUE(loaded.built) << loaded.all();
    return loaded.built ? loaded.built->problem->knot(0).model->costs()[0].residual->size() : 0;
  };
  EXPECT_EQ(rows("'joint_*'"), 7);
  EXPECT_EQ(rows("[joint_3, 'joint_*']"), 7);
  EXPECT_EQ(rows("[joint_3, 'joint_5*']"), 2);
  expect_error("residual: distance, pairs: all", "residual: joint_position, joints: ['L*']",
               "'L*' fits none of the joints");
}

}  // namespace
}  // namespace conddp
