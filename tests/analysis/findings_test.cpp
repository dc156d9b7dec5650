// Hand-written motions of a block on slides and the findings along them.
#include "analysis/findings/findings.hpp"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/block_on_slides.hpp"
#include "support/steps.hpp"

namespace conddp {
namespace {

using testing::block_phase;
using testing::block_problem;
using testing::block_system;

std::vector<Finding> found_in_motion(const ShootingProblem& problem, const Trajectory& trajectory,
                                     FindingKind kind, const FindingNames& names = {}) {
  std::vector<Finding> found;
  for (const Finding& f :
       find_in_motion(problem, trajectory, {}, NodeValues(problem, trajectory), names))
    if (f.kind == kind) found.push_back(f);
  return found;
}

bool tells(const Finding& finding, const std::string& text) {
  return (finding.message + " | " + finding.remedy).find(text) != std::string::npos;
}

TEST(LimitsOfJoints, ViolationIsLargestWhereReported) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 4)});
  Trajectory motion = problem.create_trajectory();
  motion.x(1)[0] = -0.6;
  motion.x(2)[0] = 0.5;
  motion.x(3)[0] = 0.65;
  motion.x(1)[3] = 1.5;
  motion.x(2)[3] = 1.6;
  motion.x(4)[3] = -1.75;
  motion.x(2)[1] = 101;  // along y
  const auto positions = found_in_motion(problem, motion, FindingKind::position_limit);
  ASSERT_EQ(positions.size(), 2u);
  EXPECT_EQ(positions[0].subject, "y");  // largest first
  EXPECT_NEAR(positions[0].value, 1, 1e-12);
  EXPECT_EQ(positions[0].knot, 2);
  EXPECT_EQ(positions[1].subject, "x");
  EXPECT_NEAR(positions[1].value, 0.15, 1e-12);
  EXPECT_EQ(positions[1].unit, "m");
  EXPECT_EQ(positions[1].knot, 3);
  EXPECT_NEAR(positions[1].time, 0.3, 1e-12);
  EXPECT_TRUE(tells(positions[1], "its limit of 0.5 m by 0.15")) << positions[1].message;
  const auto velocities = found_in_motion(problem, motion, FindingKind::velocity_limit);
  ASSERT_EQ(velocities.size(), 1u);
  EXPECT_NEAR(velocities[0].value, 0.25, 1e-12);
  EXPECT_EQ(velocities[0].unit, "m/s");
  EXPECT_EQ(velocities[0].knot, 4);
  EXPECT_NEAR(velocities[0].time, 0.4, 1e-12);
}

TEST(LimitsOfJoints, DoesNotAdviseLimitsTheFileBounds) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 2)});
  Trajectory motion = problem.create_trajectory();
  motion.x(1)[0] = 0.75;
  motion.x(1)[3] = 1.75;
  const auto remedies = [&](const FindingNames& names) {
    return std::pair(
        found_in_motion(problem, motion, FindingKind::position_limit, names).at(0).remedy,
        found_in_motion(problem, motion, FindingKind::velocity_limit, names).at(0).remedy);
  };
  const auto [position, velocity] = remedies({});
  EXPECT_NE(position.find("bounds: configuration, from: urdf"), std::string::npos) << position;
  EXPECT_NE(velocity.find("bounds: velocity, from: urdf"), std::string::npos) << velocity;
  EXPECT_EQ(remedies({.bounded = {"configuration"}}), std::pair(std::string(), velocity));
  EXPECT_EQ(remedies({.bounded = {"velocity"}}), std::pair(position, std::string()));
}

TEST(LimitsOfJoints, BoundsBeforeImpulsesNeedTheEnds) {
  Phase impulse = block_phase(block_system(), 1);
  impulse.instant = true;
  const ShootingProblem problem = block_problem({block_phase(block_system(), 2), impulse});
  Trajectory motion = problem.create_trajectory();
  motion.x(2)[3] = 1.75;
  const auto remedy = [&](const FindingNames& names) {
    return found_in_motion(problem, motion, FindingKind::velocity_limit, names).at(0).remedy;
  };
  const std::string ends = "bounds: velocity, from: urdf, nodes: ends";
  EXPECT_NE(remedy({}).find(ends), std::string::npos) << remedy({});
  EXPECT_NE(remedy({.bounded = {"velocity"}}).find(ends), std::string::npos);
  EXPECT_EQ(remedy({.bounded = {"velocity"}, .bounded_to_the_end = {"velocity"}}), "");
}

TEST(LimitsOfJoints, NamesTheViolatedSide) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 2)});
  Trajectory motion = problem.create_trajectory();
  motion.x(1)[0] = -0.5 - 1e-7;  // rounding
  for (const FindingKind kind : {FindingKind::position_limit, FindingKind::velocity_limit})
    EXPECT_TRUE(found_in_motion(problem, motion, kind).empty());
  motion.x(1)[0] = -0.75;
  const auto found = found_in_motion(problem, motion, FindingKind::position_limit);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(tells(found[0], "its limit of -0.5 m by 0.25")) << found[0].message;
  motion.x(1)[0] = std::nan("");
  EXPECT_TRUE(find_in_motion(problem, motion, {}, NodeValues(problem, motion), {}).empty());
}

TEST(Efforts, AreCountedAtTheirLimitInSeconds) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 5)});
  Trajectory motion = problem.create_trajectory();
  const double pushes[] = {3, 4, -4, 4 - 1e-7, 3.9};
  for (int k = 0; k < 5; ++k) motion.u(k)[0] = pushes[k];
  const auto found = found_in_motion(problem, motion, FindingKind::effort_limit);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].subject, "u/x");
  EXPECT_EQ(found[0].unit, "s");
  EXPECT_NEAR(found[0].value, 0.3, 1e-12);
  EXPECT_EQ(found[0].knot, 1);
  EXPECT_TRUE(tells(found[0], "at its limit of 4 N for 0.3 s of 0.5 s")) << found[0].message;
}

TEST(Efforts, FindsLargestEffortBeyondLimit) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 5)});
  Trajectory motion = problem.create_trajectory();
  const double pushes[] = {0, 4.5, -5.25, 5, 0};
  for (int k = 0; k < 5; ++k) motion.u(k)[0] = pushes[k];
  const auto found = found_in_motion(problem, motion, FindingKind::effort_limit);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].unit, "N");
  EXPECT_NEAR(found[0].value, 1.25, 1e-12);
  EXPECT_EQ(found[0].knot, 2);
  EXPECT_NEAR(found[0].time, 0.2, 1e-12);
  EXPECT_TRUE(tells(found[0], "1.25 N beyond its limit of -4")) << found[0].message;
}

/// Knots of 0.1 s of the block with controls linear between nodes.
ShootingProblem linear_pushes(int knots) {
  const auto system = block_system();
  Phase phase{
      .name = "push",
      .model = std::make_shared<KnotModel>(step_with(system, Integrator::rk4, Memory::linear)),
      .dt = std::vector<double>(knots, 0.1),
      .cost_scale = std::vector<double>(knots, 0.1),
      .parameters = {}};
  Phase end{
      .name = "end",
      .model = std::make_shared<KnotModel>(step_with(system, Integrator::none, Memory::linear)),
      .dt = {0},
      .cost_scale = {1},
      .parameters = {}};
  std::vector<Phase> phases;
  phases.push_back(std::move(phase));
  return ShootingProblem(std::vector<double>(9, 0.0), std::move(phases), std::move(end));
}

/// A motion whose push along x is linear between nodes.
Trajectory pushed(const ShootingProblem& problem, const std::vector<double>& pushes) {
  Trajectory motion = problem.create_trajectory();
  for (int k = 0; k <= problem.knots(); ++k) {
    motion.x(k)[6] = pushes[k];
    if (k > 0) motion.u(k - 1)[0] = pushes[k];
  }
  return motion;
}

TEST(Efforts, LinearControlStaysAtLimitBetweenSaturatedNodes) {
  const ShootingProblem problem = linear_pushes(5);
  const auto once =
      found_in_motion(problem, pushed(problem, {4, 4, 3, 4, 2, -4}), FindingKind::effort_limit);
  ASSERT_EQ(once.size(), 1u);
  EXPECT_NEAR(once[0].value, 0.1, 1e-12) << "the first knot alone";
  EXPECT_EQ(once[0].knot, 0);
  EXPECT_TRUE(
      found_in_motion(problem, pushed(problem, {0, 4, 3, 4, -4, 2}), FindingKind::effort_limit)
          .empty())
      << "the limit is touched and crossed to the other one";
}

TEST(Efforts, LinearControlExceedsLimitAtEndNodes) {
  const ShootingProblem problem = linear_pushes(3);
  for (const int node : {0, 3}) {
    std::vector<double> pushes = {1, 1, 1, 1};
    pushes[node] = -5;
    const auto found = found_in_motion(problem, pushed(problem, pushes), FindingKind::effort_limit);
    ASSERT_EQ(found.size(), 1u) << node;
    EXPECT_NEAR(found[0].value, 1, 1e-12) << node;
    EXPECT_EQ(found[0].knot, node);
    EXPECT_NEAR(found[0].time, 0.1 * node, 1e-12);
  }
}

/// Positions along x and y between −0.1 and 0.2 at all knots, and optionally at the end.
ShootingProblem within_a_window(int knots, bool also_at_the_end) {
  const auto system = block_system();
  const auto with_window = [](const std::shared_ptr<KnotModel>& model) {
    model->add_constraint(make_constraint("window", coordinate_residual(model->manifold(), {0, 1}),
                                          ConstraintKind::bounds));
  };
  auto running = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  with_window(running);
  if (also_at_the_end) with_window(end);
  const std::vector<double> window = {0, 0, -0.1, -0.1, 0.2, 0.2, 1};
  Phase phase{.name = "all", .model = running};
  for (int k = 0; k < knots; ++k) {
    phase.dt.push_back(0.1);
    phase.cost_scale.push_back(1);
    phase.parameters.insert(phase.parameters.end(), window.begin(), window.end());
  }
  Phase terminal{.name = "end", .model = end, .dt = {0}, .cost_scale = {1}};
  if (also_at_the_end) terminal.parameters = window;
  std::vector<Phase> phases;
  phases.push_back(std::move(phase));
  return ShootingProblem(std::vector<double>(6, 0.0), std::move(phases), std::move(terminal));
}

TEST(RowsOfConstraints, NamesRowsAtTheirLargestViolation) {
  const ShootingProblem problem = within_a_window(4, true);
  Trajectory motion = problem.create_trajectory();
  motion.x(1)[0] = -0.3;
  motion.x(2)[1] = 0.5;
  motion.x(3)[1] = 0.4;
  motion.x(4)[0] = 0.45;
  FindingNames names;
  names.rows["window"] = {{"left - right", "front - back"}, "m"};
  const auto found = found_in_motion(problem, motion, FindingKind::constraint_row, names);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].subject, "front - back (window)");
  EXPECT_NEAR(found[0].value, 0.3, 1e-12);
  EXPECT_EQ(found[0].knot, 2);
  EXPECT_EQ(found[1].subject, "left - right (window)");
  EXPECT_NEAR(found[1].value, 0.2, 1e-12);
  EXPECT_EQ(found[1].knot, 1);
  names.rows["terminal/window"] = {{"left - right", "front - back"}, "m"};
  const auto more = found_in_motion(problem, motion, FindingKind::constraint_row, names);
  ASSERT_EQ(more.size(), 3u);
  EXPECT_EQ(more[1].subject, "left - right (terminal/window)");
  EXPECT_NEAR(more[1].value, 0.25, 1e-12);
  EXPECT_EQ(more[1].knot, 4);
  // Names that do not fit the rows belong to something else.
  names.rows = {{"window", {{"left - right"}, "m"}}};
  EXPECT_TRUE(found_in_motion(problem, motion, FindingKind::constraint_row, names).empty());
}

/// At least this radius from the z axis at all knots.
ShootingProblem around_a_pillar(int knots, double radius = 0.5) {
  const auto system = block_system();
  auto running = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  running->add_constraint(make_constraint(
      "pillar", coordinate_residual(running->manifold(), {0, 1}), ConstraintKind::norm));
  const std::vector<double> far = {0, 0, radius, testing::kFree, 1};
  Phase phase{.name = "all", .model = running};
  for (int k = 0; k < knots; ++k) {
    phase.dt.push_back(0.1);
    phase.cost_scale.push_back(1);
    phase.parameters.insert(phase.parameters.end(), far.begin(), far.end());
  }
  std::vector<Phase> phases;
  phases.push_back(std::move(phase));
  return ShootingProblem({0.5, 0, 0, 0, 0, 0}, std::move(phases),
                         {.name = "end",
                          .model = std::make_shared<KnotModel>(system, Integrator::none),
                          .dt = {0},
                          .cost_scale = {1}});
}

TEST(BetweenKnots, ChecksConstraintsAlongTheStraightLine) {
  const ShootingProblem problem = around_a_pillar(3);
  Trajectory motion = problem.create_trajectory();
  motion.x(1) << 0, 0.5, 0, 0, 0, 0;
  motion.x(2) << 0, 0.6, 0, 0, 0, 0;
  motion.x(3) << 0, 0.6, 0, 0, 0, 0;
  // Halfway from (0.5, 0) to (0, 0.5).
  auto found = found_in_motion(problem, motion, FindingKind::between_knots);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].subject, "pillar");
  EXPECT_NEAR(found[0].value, 0.5 - 0.5 * std::sqrt(0.5), 1e-9);
  EXPECT_EQ(found[0].knot, 0);
  EXPECT_TRUE(tells(found[0], "more knots")) << found[0].remedy;
  // The motion from (0, 0.6) to (0.1, −1.8) passes (0.025, 0) at a quarter of the way.
  motion.x(3) << 0.1, -1.8, 0, 0, 0, 0;
  found = found_in_motion(problem, motion, FindingKind::between_knots);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].value, 0.475, 1e-9);
  EXPECT_EQ(found[0].knot, 2);
  EXPECT_NEAR(found[0].time, 0.2, 1e-12);
  EXPECT_TRUE(tells(found[0], "between knots 2 and 3")) << found[0].message;
  EXPECT_TRUE(tells(found[0], "jumps through")) << "more knots would lead through the pillar";
  // An equal violation at a knot is not reported again.
  motion.x(1) << 0, 0.02, 0, 0, 0, 0;
  EXPECT_TRUE(found_in_motion(problem, motion, FindingKind::between_knots).empty());
}

// Pillars of a twentieth of a step, wherever the motion passes them.
TEST(BetweenKnots, FindsObstaclesThinnerThanItsSamples) {
  constexpr double kRadius = 0.025;
  for (const double past : {0.03, 0.11, 0.31, 0.4, 0.73})
    for (const double beside : {0.0, 0.015, 0.03}) {
      const ShootingProblem problem = around_a_pillar(2, kRadius);
      Trajectory motion = problem.create_trajectory();
      motion.x(0) << past - 1, beside, 0, 0, 0, 0;
      motion.x(1) << past, beside, 0, 0, 0, 0;
      motion.x(2) = motion.x(1);
      const auto found = found_in_motion(problem, motion, FindingKind::between_knots);
      ASSERT_EQ(found.size(), beside < kRadius ? 1u : 0u) << past << " " << beside;
      for (const Finding& f : found) EXPECT_GT(f.value, 0.4 * (kRadius - beside)) << past;
    }
}

/// The window at the given knots only.
ShootingProblem gate_at(const std::set<int>& gates, int knots) {
  const auto system = block_system();
  auto running = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  running->add_constraint(make_constraint("gate", coordinate_residual(running->manifold(), {0, 1}),
                                          ConstraintKind::bounds));
  Phase phase{.name = "all", .model = running};
  for (int k = 0; k < knots; ++k) {
    phase.dt.push_back(0.1);
    phase.cost_scale.push_back(1);
    const double active = gates.contains(k) ? 1 : 0;
    for (const double number : {0.0, 0.0, -0.1, -0.1, 0.2, 0.2, active})
      phase.parameters.push_back(number);
  }
  std::vector<Phase> phases;
  phases.push_back(std::move(phase));
  return ShootingProblem(std::vector<double>(6, 0.0), std::move(phases),
                         {.name = "end",
                          .model = std::make_shared<KnotModel>(system, Integrator::none),
                          .dt = {0},
                          .cost_scale = {1}});
}

TEST(BetweenKnots, SkipsGateAfterItsLastKnot) {
  for (const std::set<int>& gates : {std::set{2}, std::set{1, 2}, std::set{4}}) {
    const ShootingProblem problem = gate_at(gates, 5);
    Trajectory motion = problem.create_trajectory();
    motion.x(*gates.rbegin() + 1)[0] = 3;
    EXPECT_TRUE(found_in_motion(problem, motion, FindingKind::between_knots).empty())
        << *gates.rbegin();
  }
}

/// A window throughout the first of two phases with this many knots each.
ShootingProblem window_in_first_phase(int knots) {
  const auto system = block_system();
  auto bounded = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  bounded->add_constraint(make_constraint("window", coordinate_residual(bounded->manifold(), {0}),
                                          ConstraintKind::bounds));
  const auto free = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  const std::vector<double> dt(knots, 0.1), scale(knots, 1.0);
  Phase first{.name = "first", .model = bounded, .dt = dt, .cost_scale = scale};
  for (int k = 0; k < knots; ++k)
    for (const double number : {0.0, -0.1, 0.2, 1.0}) first.parameters.push_back(number);
  std::vector<Phase> phases;
  phases.push_back(std::move(first));
  phases.push_back({.name = "second", .model = free, .dt = dt, .cost_scale = scale});
  return ShootingProblem(std::vector<double>(6, 0.0), std::move(phases),
                         {.name = "end",
                          .model = std::make_shared<KnotModel>(system, Integrator::none),
                          .dt = {0},
                          .cost_scale = {1}});
}

TEST(BetweenKnots, FindsViolationAtEndOfEveryPhase) {
  const ShootingProblem problem = window_in_first_phase(3);
  Trajectory motion = problem.create_trajectory();
  motion.x(4)[0] = 5;  // after the phase
  EXPECT_TRUE(found_in_motion(problem, motion, FindingKind::between_knots).empty());
  motion.x(3)[0] = 0.7;
  const auto found = found_in_motion(problem, motion, FindingKind::between_knots);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].value, 0.5, 1e-9);
  EXPECT_EQ(found[0].knot, 3);
  EXPECT_TRUE(tells(found[0], "node 3, the end of the phase 'first'")) << found[0].message;
  EXPECT_EQ(found[0].remedy, "'nodes: ends'");
}

TEST(BetweenKnots, NamesTheWorstRow) {
  const ShootingProblem problem = within_a_window(3, false);
  FindingNames names;
  names.rows["window"] = {{"left - right", "front - back"}, "m"};
  Trajectory motion = problem.create_trajectory();
  for (const double end : {-0.3, -0.8}) {
    motion.x(3)[1] = end;
    const auto found = found_in_motion(problem, motion, FindingKind::between_knots, names);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0].value, -0.1 - end, 1e-9);
    EXPECT_EQ(found[0].knot, 3);
    EXPECT_TRUE(tells(found[0], fmt::format("{:.3g} m by front - back at the last node, where it "
                                            "is not enforced",
                                            -0.1 - end)))
        << found[0].message;
    EXPECT_EQ(found[0].remedy, "'nodes: ends'");
  }
  motion.x(3)[1] = -0.1;
  EXPECT_TRUE(found_in_motion(problem, motion, FindingKind::between_knots, names).empty());
}

TEST(BetweenKnots, FindsNothingAtTheLastNode) {
  const ShootingProblem problem = within_a_window(3, true);
  Trajectory motion = problem.create_trajectory();
  motion.x(3)[1] = -0.8;
  EXPECT_TRUE(found_in_motion(problem, motion, FindingKind::between_knots).empty());
}

/// Findings for a push along x in the last knot.
std::vector<Finding> last_push(std::vector<double> pushes, int earlier_phase = 0) {
  std::vector<Phase> phases;
  if (earlier_phase > 0) phases.push_back(block_phase(block_system(), earlier_phase));
  phases.push_back(block_phase(block_system(), static_cast<int>(pushes.size()) - earlier_phase));
  const ShootingProblem problem = block_problem(std::move(phases));
  Trajectory motion = problem.create_trajectory();
  for (std::size_t k = 0; k < pushes.size(); ++k) motion.u(static_cast<int>(k))[0] = pushes[k];
  return found_in_motion(problem, motion, FindingKind::last_knot);
}

TEST(LastKnot, JumpIsThreeTimesTheEarlierSteps) {
  const auto found = last_push({0, 0.1, 0.2, 0.1, 0, 0.1, 0.9});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].subject, "u/x");
  EXPECT_NEAR(found[0].value, 0.8, 1e-12);
  EXPECT_EQ(found[0].unit, "N");
  EXPECT_EQ(found[0].knot, 6);
  EXPECT_NEAR(found[0].time, 0.6, 1e-12);
  EXPECT_TRUE(tells(found[0], "by 0.8 N at the last knot, by 0.1 at most")) << found[0].message;
  EXPECT_EQ(last_push({0, 0.1, 0.2, 0.1, 0, 0.1, -0.21}).size(), 1u);
  EXPECT_EQ(last_push({0, 0.1, 0.2, 0.1, 0, 0.1, 0.39}).size(), 0u);
  // Small relative to the range of all pushes: 0.4 of 2.1.
  EXPECT_EQ(last_push({0,   0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1,  1.1,
                       1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2,   2.1, 1.7})
                .size(),
            0u);
}

TEST(LastKnot, IgnoresJumpsBelowAThousandthOfTheLimit) {
  constexpr double kEffort = 4;  // N, block along x
  EXPECT_EQ(last_push({0, 0, 0, 0, 0, 1.001e-3 * kEffort}).size(), 1u);
  EXPECT_EQ(last_push({0, 0, 0, 0, 0, 0.999e-3 * kEffort}).size(), 0u);
}

TEST(LastKnot, ComparesWithinPhasesOfAtLeastSixKnots) {
  EXPECT_EQ(last_push({0, 0, 0, 0, 0, 1}).size(), 1u);
  EXPECT_EQ(last_push({0, 0, 0, 0, 1}).size(), 0u);
  EXPECT_EQ(last_push({0, 0, 0, 0, 0, 1}, 1).size(), 0u);
  // A jump in the previous phase does not count.
  EXPECT_EQ(last_push({0, 5, 0, 0, 0, 0, 0, 1}, 2).size(), 1u);
}

/// A body of 2 kg with its center of mass 0.1 m above the origin and thrusters at these places.
std::vector<Finding> thrusters_at(
    const std::vector<std::pair<Vector3<double>, Vector3<double>>>& places, bool held = false) {
  std::string urdf =
      R"(<robot name="ship"><link name="hull"><inertial><origin xyz="0 0 0.1"/><mass value="2"/>)"
      R"(<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>)";
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& p = places[i].first;
    const std::string name = "jet" + std::to_string(i);
    urdf += "<link name=\"" + name + "\"/><joint name=\"to_" + name +
            "\" type=\"fixed\"><parent link=\"hull\"/><child link=\"" + name +
            "\"/><origin xyz=\"" + std::to_string(p.x) + " " + std::to_string(p.y) + " " +
            std::to_string(p.z) + "\"/></joint>";
  }
  const auto robot = std::make_shared<const RobotModel>(
      parse_urdf(urdf + "</robot>", "ship.urdf", {.base = UrdfOptions::Base::floating})
          .model.value());
  std::vector<Thruster> thrusters;
  for (std::size_t i = 0; i < places.size(); ++i)
    thrusters.push_back({.name = "jet" + std::to_string(i),
                         .frame = *robot->find_frame("jet" + std::to_string(i)),
                         .direction = places[i].second});
  const std::vector<Contact> contacts(held ? 1 : 0, {.name = "rope", .frame = 0});
  const auto system = std::make_shared<MultibodySystem>(
      robot, Actuation::thrusters(*robot, thrusters, {}), PassiveForces{}, contacts);
  std::vector<double> start(13, 0.0);
  start[6] = 1;
  const ShootingProblem problem =
      testing::tracking_problem(system, Integrator::semi_implicit_euler, 2, 0.1, start,
                                {.goal = start,
                                 .q = std::vector<double>(12, 1.0),
                                 .r = std::vector<double>(places.size(), 1.0),
                                 .qf = std::vector<double>(12, 1.0)});
  return found_in_motion(problem, problem.create_trajectory(), FindingKind::thrusters);
}

TEST(Thrusters, CannotTurnAboutAxesThroughCenterOfMass) {
  const Vector3<double> x{1, 0, 0}, z{0, 0, 1}, origin{0, 0, 0};
  // Both rotate about y: one through its position, the other through the height of the center of
  // mass.
  const auto about_y = thrusters_at({{{0.2, 0, 0}, z}, {origin, x}});
  ASSERT_EQ(about_y.size(), 1u);
  EXPECT_EQ(about_y[0].value, 2);
  EXPECT_EQ(about_y[0].knot, -1);
  EXPECT_TRUE(tells(about_y[0], "about its axes x, z")) << about_y[0].message;
  // A push at the height of the center of mass produces no torque.
  const auto none = thrusters_at({{origin, z}, {{0, 0, 0.1}, x}});
  ASSERT_EQ(none.size(), 1u);
  EXPECT_EQ(none[0].value, 3);
  // Torque about x and z together, and about y.
  const auto two = thrusters_at({{{0.2, 0, 0}, z}, {{0.1, 0.3, 0.1}, {0.6, 0, 0.8}}});
  ASSERT_EQ(two.size(), 1u);
  EXPECT_EQ(two[0].value, 1);
  EXPECT_TRUE(tells(two[0], "about 1 of 3 directions")) << two[0].message;
  EXPECT_TRUE(thrusters_at({{{0.2, 0, 0}, z}, {{0, 0.2, 0}, z}, {{0, 0.2, 0.1}, x}}).empty());
  // The world may exert a torque on a body that it holds.
  EXPECT_TRUE(thrusters_at({{origin, z}}, true).empty());
}

TEST(Findings, CoverControlsOfSystemsWithoutRobot) {
  const ShootingProblem problem = testing::pendulum_swing_up(3);
  Trajectory motion = problem.create_trajectory();
  EXPECT_TRUE(find_in_motion(problem, motion, {}, NodeValues(problem, motion), {}).empty());
  motion.u(problem.knots() - 1)[0] = 2;
  const auto found = find_in_motion(problem, motion, {}, NodeValues(problem, motion), {});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, FindingKind::last_knot);
  EXPECT_NEAR(found[0].value, 2, 1e-15);
}

// An impulse takes no time: it has no controls and no efforts.
TEST(Efforts, SkipInstantaneousKnots) {
  const ShootingProblem problem = testing::landing();
  Trajectory motion = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k)
    if (problem.nu(k) == 2) motion.u(k) << 1e4, 0;
  const auto found = found_in_motion(problem, motion, FindingKind::effort_limit);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].subject, "u/hip");
  EXPECT_EQ(found[0].knot, 0);
}

/// Five knots of a mass on a line; only the second has narrow bounds on a row. Between it and
/// the third node, where the mass is at 4, the violation reaches 2. `instant`: the narrow knot
/// takes no time.
std::vector<Finding> between_narrow_and_wide(const std::shared_ptr<const Residual>& row,
                                             Softness softness, double lower,
                                             Memory memory = Memory::none, bool instant = false) {
  const auto system = double_integrator(1);
  auto model = std::make_shared<KnotModel>(step_with(system, Integrator::rk4, memory));
  model->add_constraint(make_constraint("row", row, ConstraintKind::bounds, 1, softness));
  std::vector<Phase> phases;
  for (int k = 0; k < 5; ++k) {
    Phase phase{.name = "knot", .model = model, .dt = {0.1}, .cost_scale = {1}};
    phase.parameters = {k == 1 ? lower : -9, k == 1 ? 1.0 : 9.0, 1};
    if (softness != Softness::hard) phase.parameters.push_back(1);
    phase.instant = instant && k == 1;
    phases.push_back(std::move(phase));
  }
  const ShootingProblem problem(
      std::vector<double>(model->nx(), 0.0), std::move(phases),
      {.name = "end",
       .model = std::make_shared<KnotModel>(step_with(system, Integrator::none, memory)),
       .dt = {0},
       .cost_scale = {1}});
  Trajectory motion = problem.create_trajectory();
  for (int k = 2; k <= 5; ++k) motion.x(k).setConstant(4);
  for (int k = 0; k < 5; ++k) motion.u(k).setConstant(4);
  return found_in_motion(problem, motion, FindingKind::between_knots);
}

TEST(BetweenKnots, ChecksOnlyHardInequalitiesOfTheState) {
  using Term = LinearCombination::Term;
  const auto row_of = [](std::vector<Term> terms) {
    return combination_residual(2, {{.terms = std::move(terms)}});
  };
  const Term place{1, false, 0, 0}, push{0, true, 0, 0};
  const auto found = between_narrow_and_wide(row_of({place}), Softness::hard, -1);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].value, 2, 1e-12);
  EXPECT_EQ(found[0].knot, 1);
  EXPECT_TRUE(between_narrow_and_wide(row_of({place}), Softness::l1, -1).empty());
  EXPECT_TRUE(between_narrow_and_wide(row_of({place, push}), Softness::hard, -1).empty());
  EXPECT_TRUE(between_narrow_and_wide(row_of({place}), Softness::hard, 1).empty()) << "equality";
  EXPECT_TRUE(
      between_narrow_and_wide(row_of({place}), Softness::hard, -1, Memory::none, true).empty())
      << "a jump has no way";
  // Linear controls are states and are judged at the nodes only.
  const Memory linear = Memory::linear;
  EXPECT_EQ(between_narrow_and_wide(row_of({place}), Softness::hard, -1, linear).size(), 1u);
  EXPECT_TRUE(
      between_narrow_and_wide(row_of({{1, true, 0, 0}}), Softness::hard, -1, linear).empty());
}

// A millionth of the limit, 4e-6 N, counts as rounding.
TEST(Efforts, RoundingBeyondTheLimitCountsAsAtIt) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 2)});
  Trajectory motion = problem.create_trajectory();
  for (const double off : {3.9e-6, 4.1e-6}) {
    motion.u(1)[0] = -4 - off;
    const auto found = found_in_motion(problem, motion, FindingKind::effort_limit);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].unit, off < 4e-6 ? "s" : "N");
  }
  motion.u(1)[0] = -4 + 3.9e-6;
  EXPECT_EQ(found_in_motion(problem, motion, FindingKind::effort_limit).size(), 1u);
  motion.u(1)[0] = -4 + 4.1e-6;
  EXPECT_TRUE(found_in_motion(problem, motion, FindingKind::effort_limit).empty());
}

// The center of mass is offset in all directions; forces through it produce no torque.
TEST(Thrusters, ThroughCenterOfMassProduceNoTorque) {
  const std::string urdf =
      R"(<robot name="ship"><link name="hull"><inertial><origin xyz="0.1 0.2 0.3"/>)"
      R"(<mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>)"
      R"(</link><link name="jet"/><joint name="to_jet" type="fixed"><parent link="hull"/>)"
      R"(<child link="jet"/><origin xyz="0.1 0.2 0.3"/></joint>)";
  const std::string arm =
      R"(<link name="arm"><inertial><mass value="1"/>)"
      R"(<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>)"
      R"(<joint name="elbow" type="revolute"><parent link="hull"/><child link="arm"/>)"
      R"(<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>)";
  for (const bool with_arm : {false, true}) {
    const auto robot = std::make_shared<const RobotModel>(
        parse_urdf(urdf + (with_arm ? arm : "") + "</robot>", "ship.urdf",
                   {.base = UrdfOptions::Base::floating})
            .model.value());
    std::vector<Thruster> jets;
    for (const Vector3<double>& direction :
         {Vector3<double>{1, 0, 0}, Vector3<double>{0, 1, 0}, Vector3<double>{0, 0, 1}})
      jets.push_back({.name = "jet" + std::to_string(jets.size()),
                      .frame = *robot->find_frame("jet"),
                      .direction = direction});
    const auto system = std::make_shared<MultibodySystem>(
        robot, Actuation::thrusters(*robot, jets, {}), PassiveForces{}, std::vector<Contact>{});
    std::vector<double> start(system->nx(), 0.0);
    start[6] = 1;
    const std::vector<double> ones(system->ndx(), 1.0);
    const ShootingProblem problem =
        testing::tracking_problem(system, Integrator::semi_implicit_euler, 2, 0.1, start,
                                  {.goal = start, .q = ones, .r = {1, 1, 1}, .qf = ones});
    const auto found =
        found_in_motion(problem, problem.create_trajectory(), FindingKind::thrusters);
    ASSERT_EQ(found.size(), with_arm ? 0u : 1u) << "an arm may turn it";
    if (with_arm) continue;
    EXPECT_EQ(found[0].value, 3);
    EXPECT_TRUE(tells(found[0], "about its axes x, y, z")) << found[0].message;
  }
}

/// A residual that looks up a table over [−1, 3] at the first state.
class TableResidual : public ResidualBase<TableResidual> {
 public:
  explicit TableResidual(std::string table)
      : ResidualBase({{1, {0}}}, 0, false), table_(std::move(table)) {}
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    r[0] = in.x[0];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    jacobian[0] = S(1.0);
  }
  std::vector<TableReading> table_readings(const double* x, const double* /*u*/,
                                           const double* /*parameters*/) const override {
    return {{table_, x[0], -1, 3}};
  }

 private:
  std::string table_;
};

/// Six knots of a mass with tables in a cost and a constraint, active at some nodes only.
struct TablesOnTheWay {
  std::set<int> cost_at = {0, 1, 2, 3, 4, 5, 6}, constraint_at = {};

  std::vector<Finding> found(const std::vector<double>& places) const {
    const auto system = double_integrator(1);
    const auto phase_of = [&](int first, int knots, Integrator integrator) {
      auto model = std::make_shared<KnotModel>(system, integrator);
      model->add_cost("cost", std::make_shared<TableResidual>("drag"), {});
      model->add_constraint(
          make_constraint("row", std::make_shared<TableResidual>("floor"), ConstraintKind::bounds));
      Phase phase{.name = "phase", .model = model};
      for (int k = first; k < first + knots; ++k) {
        phase.dt.push_back(integrator == Integrator::none ? 0 : 0.1);
        phase.cost_scale.push_back(1);
        for (const double number : {cost_at.contains(k) ? 2.0 : 0.0, -testing::kFree,
                                    testing::kFree, constraint_at.contains(k) ? 1.0 : 0.0})
          phase.parameters.push_back(number);
      }
      return phase;
    };
    std::vector<Phase> phases;
    phases.push_back(phase_of(0, 6, Integrator::rk4));
    const ShootingProblem problem({0, 0}, std::move(phases), phase_of(6, 1, Integrator::none));
    Trajectory motion = problem.create_trajectory();
    for (int k = 0; k <= 6; ++k) motion.x(k)[0] = places[k];
    return found_in_motion(problem, motion, FindingKind::table_range);
  }
};

TEST(Tables, ReportsLookupsBeyondEitherEnd) {
  const auto found = TablesOnTheWay{}.found({0, 3.5, -1.25, 4, 3.75, 0, 0});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].subject, "drag");
  EXPECT_NEAR(found[0].value, 1, 1e-15);
  EXPECT_EQ(found[0].knot, 3);
  EXPECT_NEAR(found[0].time, 0.3, 1e-12);
  EXPECT_TRUE(tells(found[0], "is read at 4, beyond its last point 3, at knots 1 to 4"))
      << found[0].message;
  EXPECT_NEAR(found[1].value, 0.25, 1e-15);
  EXPECT_EQ(found[1].knot, 2);
  EXPECT_TRUE(tells(found[1], "is read at -1.25, beyond its first point -1, at knot 2"))
      << found[1].message;
  // The first of equally distant lookups is reported; a millionth of the table's range is rounding.
  const auto twice = TablesOnTheWay{}.found({3.5, 0, 0, 0, 0, 0, 3.5});
  ASSERT_EQ(twice.size(), 1u);
  EXPECT_EQ(twice[0].knot, 0);
  EXPECT_TRUE(tells(twice[0], "at knots 0 to 6")) << twice[0].message;
  EXPECT_TRUE(TablesOnTheWay{}.found({0, 3 + 3.9e-6, -1 - 3.9e-6, 3, -1, 0, 0}).empty());
  EXPECT_EQ(TablesOnTheWay{}.found({0, 3 + 4.1e-6, -1 - 4.1e-6, 3, -1, 0, 0}).size(), 2u);
}

TEST(Tables, CountOnlyWithTheirCostOrConstraint) {
  const TablesOnTheWay some{.cost_at = {1, 6}, .constraint_at = {2, 6}};
  const auto subjects = [&](int node) {
    std::vector<double> places(7, 0.0);
    places[node] = 5;
    std::string names;
    for (const Finding& f : some.found(places)) names += f.subject + " ";
    return names;
  };
  EXPECT_EQ(subjects(0), "");
  EXPECT_EQ(subjects(1), "drag ");
  EXPECT_EQ(subjects(2), "floor ");
  EXPECT_EQ(subjects(3), "");
  EXPECT_EQ(subjects(6), "drag floor ");
}

}  // namespace
}  // namespace conddp
