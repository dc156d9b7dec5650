// A block on slides held by the world; its forces and displacements are known analytically.
#include "analysis/findings/contact_findings.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/block_on_slides.hpp"

namespace conddp {
namespace {

using testing::block_phase;
using testing::block_problem;
using testing::block_system;

constexpr double kBlockWeight = 2 * 9.81;

/// Findings of one kind for a motion in which the block is held.
std::vector<Finding> found_in_contacts(const ShootingProblem& problem, const Trajectory& motion,
                                       FindingKind kind, const FindingNames& names = {}) {
  std::vector<Finding> all, found;
  find_in_contacts(problem, motion, NodeValues(problem, motion), names, all);
  for (const Finding& f : all)
    if (f.kind == kind) found.push_back(f);
  return found;
}

bool mentions(const Finding& finding, const std::string& text) {
  return (finding.message + " | " + finding.remedy).find(text) != std::string::npos;
}

/// Sets the force with which the world holds the block at knot k.
void hold(Trajectory& motion, int k, double x, double y, double z) {
  motion.u(k) << -x, -y, kBlockWeight - z;
}

TEST(FrictionDemand, IsTheTangentialShareOfTheForce) {
  const ShootingProblem problem = block_problem({block_phase(block_system({{.name = "grip"}}), 3)});
  Trajectory motion = problem.create_trajectory();
  hold(motion, 0, 1, 0, 10);
  hold(motion, 1, 3, 4, 10);
  hold(motion, 2, 5, 0, 20);
  const auto plain = found_in_contacts(problem, motion, FindingKind::friction_demand);
  ASSERT_EQ(plain.size(), 1u);
  EXPECT_EQ(plain[0].subject, "grip");
  EXPECT_NEAR(plain[0].value, 0.5, 1e-9);
  EXPECT_EQ(plain[0].knot, 1);
  EXPECT_NEAR(plain[0].time, 0.1, 1e-12);
  EXPECT_EQ(plain[0].remedy, "");
  const auto enough = found_in_contacts(problem, motion, FindingKind::friction_demand,
                                        {.friction = {{"grip", 0.6}}});
  EXPECT_TRUE(mentions(enough.at(0), "0.6 are there")) << enough[0].message;
  EXPECT_EQ(enough[0].remedy, "");
  const auto lacking = found_in_contacts(problem, motion, FindingKind::friction_demand,
                                         {.friction = {{"grip", 0.4}}});
  EXPECT_TRUE(mentions(lacking.at(0), "0.4 is what it has")) << lacking[0].message;
  EXPECT_TRUE(mentions(lacking[0], "friction_cone"));
  EXPECT_TRUE(found_in_contacts(problem, motion, FindingKind::pull).empty());
}

TEST(FrictionDemand, NamesTheFirstOfEqualContactsAndKnots) {
  const ShootingProblem problem =
      block_problem({block_phase(block_system({{.name = "left"}}), 2),
                     block_phase(block_system({{.name = "right"}}), 1)});
  Trajectory motion = problem.create_trajectory();
  hold(motion, 0, 5, 0, 10);
  hold(motion, 1, 5 + 1e-8, 0, 10);
  hold(motion, 2, 5 + 2e-8, 0, 10);
  auto found = found_in_contacts(problem, motion, FindingKind::friction_demand);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].subject, "left");
  EXPECT_EQ(found[0].knot, 0);
  hold(motion, 2, 5.1, 0, 10);
  found = found_in_contacts(problem, motion, FindingKind::friction_demand);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].subject, "right");
}

TEST(FrictionDemand, IgnoresFrictionlessContacts) {
  const ShootingProblem problem = block_problem(
      {block_phase(block_system({{.name = "rest", .kind = ContactKind::normal}}), 2)});
  Trajectory motion = problem.create_trajectory();
  hold(motion, 0, 3, 4, 10);
  EXPECT_TRUE(found_in_contacts(problem, motion, FindingKind::friction_demand).empty());
}

TEST(FrictionDemand, UsesTheTiltedContactNormal) {
  const ShootingProblem problem =
      block_problem({block_phase(block_system({{.name = "wall", .normal = {1, 0, 0}}}), 2)});
  Trajectory motion = problem.create_trajectory();
  hold(motion, 0, 10, 0, 2);
  hold(motion, 1, 10, 0, 0);
  const auto found = found_in_contacts(problem, motion, FindingKind::friction_demand);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].value, 0.2, 1e-9);
  EXPECT_EQ(found[0].knot, 0);
}

TEST(Pull, IsTheForceAgainstTheNormal) {
  const ShootingProblem problem = block_problem({block_phase(block_system({{.name = "grip"}}), 3)});
  Trajectory motion = problem.create_trajectory();
  hold(motion, 0, 0, 0, -1);
  hold(motion, 1, 1, 0, -2);
  hold(motion, 2, 0, 0, 5);
  const auto found = found_in_contacts(problem, motion, FindingKind::pull);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].value, 2, 1e-9);
  EXPECT_EQ(found[0].unit, "N");
  EXPECT_EQ(found[0].knot, 1);
  EXPECT_NEAR(found[0].time, 0.1, 1e-12);
}

TEST(Friction, DoesNotAdviseConesTheFileEnforces) {
  const ShootingProblem problem = block_problem({block_phase(block_system({{.name = "grip"}}), 1)});
  Trajectory motion = problem.create_trajectory();
  hold(motion, 0, 5, 0, 1);
  const auto remedy = [&](std::vector<FindingNames::Cone> cones) {
    FindingNames names{.friction = {{"grip", 0.9}}, .cones = {{"grip", std::move(cones)}}};
    if (names.cones["grip"].empty()) names.cones = {{"other", {{"c", true}}}};
    const auto found = found_in_contacts(problem, motion, FindingKind::friction_demand, names);
    return found.size() == 1 ? found[0].remedy : "not one finding";
  };
  EXPECT_EQ(remedy({}), "a constraint or cost 'friction_cone' on it");
  EXPECT_EQ(remedy({{"w", false}, {"c", true}}), "");
  EXPECT_EQ(remedy({{"c", true, false}, {"w", false}}),
            "a larger weight of the cost 'w', or a constraint 'friction_cone'");
  EXPECT_EQ(remedy({{"c", true, false}}), "the constraint 'c' at all knots");
}

// A thousandth of the weight of all three bodies (4 kg) is 0.039 N.
TEST(Pull, IgnoresAThousandthOfTheWeight) {
  const ShootingProblem problem = block_problem({block_phase(block_system({{.name = "grip"}}), 1)});
  Trajectory motion = problem.create_trajectory();
  hold(motion, 0, 0, 0, -0.035);
  EXPECT_TRUE(found_in_contacts(problem, motion, FindingKind::pull).empty());
  hold(motion, 0, 0, 0, -0.045);
  EXPECT_EQ(found_in_contacts(problem, motion, FindingKind::pull).size(), 1u);
  hold(motion, 0, 1, 0, 0.035);
  EXPECT_TRUE(found_in_contacts(problem, motion, FindingKind::friction_demand).empty());
  hold(motion, 0, 1, 0, 0.045);
  EXPECT_EQ(found_in_contacts(problem, motion, FindingKind::friction_demand).size(), 1u);
}

// The world stops the block instantly: 4 kg along x at 0.5 m/s, 2 kg along z at −1 m/s.
TEST(Impulses, ReportDemandAndPullInNewtonSeconds) {
  const auto robot = testing::block_on_slides();
  const std::vector<Contact> grip = {{.name = "grip", .frame = *robot->find_frame("block")}};
  const auto impact = std::make_shared<MultibodySystem>(robot, grip, 0.0);
  std::vector<Phase> phases;
  phases.push_back(testing::tracking_phase(
      impact, Integrator::impulse, 1, 0,
      {.goal = std::vector<double>(6, 0.0), .q = std::vector<double>(6, 1.0)}, 0, 0));
  const ShootingProblem problem = block_problem(std::move(phases));
  Trajectory motion = problem.create_trajectory();
  motion.x(0) << 0, 0, 0, 0.5, 0, -1;
  const auto demand = found_in_contacts(problem, motion, FindingKind::friction_demand,
                                        {.friction = {{"grip", 0.9}}});
  ASSERT_EQ(demand.size(), 1u);
  EXPECT_NEAR(demand[0].value, (4 * 0.5) / (2 * 1.0), 1e-9);
  EXPECT_TRUE(mentions(demand[0], "less speed along the ground"));
  EXPECT_TRUE(mentions(demand[0], "'friction_cone' with 'phases: ")) << demand[0].remedy;
  motion.x(0) << 0, 0, 0, 0, 0, 1.5;
  const auto pull = found_in_contacts(problem, motion, FindingKind::pull);
  ASSERT_EQ(pull.size(), 1u);
  EXPECT_NEAR(pull[0].value, 3, 1e-9);
  EXPECT_EQ(pull[0].unit, "Ns");
  // A thousandth of the momentum of 4 kg at 1 m/s.
  motion.x(0) << 0, 0, 0, 0, 0, 0.0021;
  EXPECT_EQ(found_in_contacts(problem, motion, FindingKind::pull).size(), 1u);
  motion.x(0) << 0, 0, 0, 0, 0, 0.0019;
  EXPECT_TRUE(found_in_contacts(problem, motion, FindingKind::pull).empty());
}

/// Drift findings for a block that is held from the first knot.
std::vector<Finding> drift_of(const Contact& contact,
                              const std::vector<Vector3<double>>& positions) {
  const ShootingProblem problem =
      block_problem({block_phase(block_system({contact}), static_cast<int>(positions.size()) - 1)});
  Trajectory motion = problem.create_trajectory();
  for (std::size_t k = 0; k < positions.size(); ++k)
    motion.x(static_cast<int>(k)).head(3) << positions[k].x, positions[k].y, positions[k].z;
  return found_in_contacts(problem, motion, FindingKind::drift);
}

TEST(Drift, IsLargestDistanceFromStartOfStance) {
  const auto found = drift_of({.name = "grip", .kd = 5},
                              {{0.1, 0, 0}, {0.103, 0.004, 0}, {0.1, 0.002, 0}, {0.1, 0, 0}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].value, 0.005, 1e-12);
  EXPECT_EQ(found[0].unit, "m");
  EXPECT_EQ(found[0].knot, 1);
  EXPECT_TRUE(mentions(found[0], "by 5.0 mm while it is held from 0 s to 0.3 s"))
      << found[0].message;
  EXPECT_TRUE(mentions(found[0], "kd: 10")) << found[0].remedy;
  const auto stiff = drift_of({.name = "grip", .kd = 20}, {{0, 0, 0}, {0, 0.004, 0}});
  ASSERT_EQ(stiff.size(), 1u);
  EXPECT_TRUE(mentions(stiff[0], "smaller dt")) << stiff[0].remedy;
  EXPECT_TRUE(drift_of({.name = "grip"}, {{0, 0, 0}, {0, 0.0009, 0}}).empty());
  // Oscillation about the start: the distance between knots exceeds the distance from the start.
  const auto back = drift_of({.name = "grip"}, {{0, 0, 0}, {0, 0.005, 0}, {0, -0.004, 0}});
  ASSERT_EQ(back.size(), 1u);
  EXPECT_NEAR(back[0].value, 0.005, 1e-12);
}

TEST(Drift, AdvisesNoKpTowardsAnotherPlace) {
  const auto remedy = [](double x, double kp) {
    const auto found = drift_of({.name = "grip", .kp = kp, .kd = 20}, {{x, 0, 0}, {x, 0.004, 0}});
    return found.size() == 1 ? found[0].remedy : "not one finding";
  };
  EXPECT_EQ(remedy(0, 0),
            "a smaller dt with contacts.grip.baumgarte.kd: 1/dt, or contacts.grip.baumgarte.kp");
  EXPECT_EQ(remedy(0, 5),
            "a smaller dt with contacts.grip.baumgarte.kd: 1/dt, or a larger "
            "contacts.grip.baumgarte.kp");
  EXPECT_EQ(remedy(0.3, 5), "a smaller dt with contacts.grip.baumgarte.kd: 1/dt");
  const auto held = block_system({{.name = "grip", .kd = 20}});
  const ShootingProblem problem =
      block_problem({block_phase(block_system(), 1), block_phase(held, 2)});
  Trajectory motion = problem.create_trajectory();
  motion.x(3)[0] = 0.004;
  const auto later = found_in_contacts(problem, motion, FindingKind::drift);
  ASSERT_EQ(later.size(), 1u);
  EXPECT_EQ(later[0].remedy, "a smaller dt with contacts.grip.baumgarte.kd: 1/dt");
  const auto loop = found_in_contacts(problem, motion, FindingKind::drift,
                                      {.contact_keys = {{"grip", "loops.grip"}}});
  ASSERT_EQ(loop.size(), 1u);
  EXPECT_EQ(loop[0].remedy, "a smaller dt with loops.grip.baumgarte.kd: 1/dt");
}

// One kd serves all stances: that of the fine steps would be unstable with the long ones.
TEST(Drift, AdvisedKdFitsTheLongestStep) {
  const auto held = block_system({{.name = "grip", .kd = 5}});
  Phase fine = block_phase(held, 2);
  fine.dt = {0.02, 0.02};
  const ShootingProblem problem =
      block_problem({fine, block_phase(block_system(), 1), block_phase(held, 1)});
  Trajectory motion = problem.create_trajectory();
  motion.x(2)[0] = 0.004;
  const auto found = found_in_contacts(problem, motion, FindingKind::drift);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(mentions(found[0], "kd: 10")) << found[0].remedy;
}

// The block arrives at this speed, and its contact lets it move on by 2 cm.
TEST(Drift, AdvisesImpulsesWhereRulesFollowTheDamping) {
  const auto remedy = [](Integrator rule, double speed) {
    const std::vector<double> zero(6, 0.0), one(6, 1.0);
    const Phase stance = testing::tracking_phase(block_system({{.name = "grip", .kd = 20}}), rule,
                                                 1, 0.1, {.goal = zero, .q = one, .r = {1, 1, 1}},
                                                 -testing::kFree, testing::kFree);
    const ShootingProblem problem = block_problem({block_phase(block_system(), 1), stance});
    Trajectory motion = problem.create_trajectory();
    motion.x(1)[0] = 0.1 * speed;
    motion.x(2)[0] = motion.x(1)[0] + 0.02;
    const auto found = found_in_contacts(problem, motion, FindingKind::drift);
    return found.size() == 1 ? found[0].remedy : "not one finding";
  };
  EXPECT_NE(remedy(Integrator::rk4, 0.5).find("impulses: true"), std::string::npos);
  EXPECT_NE(remedy(Integrator::rk4, 0.5).find("at 0.5 m/s"), std::string::npos);
  EXPECT_EQ(remedy(Integrator::rk4, 0.1).find("impulse"), std::string::npos);
  EXPECT_EQ(remedy(Integrator::semi_implicit_euler, 0.5).find("impulse"), std::string::npos);
}

TEST(Drift, CountsAlongConstrainedDirections) {
  const Contact rest{.name = "rest", .kind = ContactKind::normal};
  EXPECT_TRUE(drift_of(rest, {{0, 0, 0}, {0.1, 0.1, 0}}).empty());
  EXPECT_NEAR(drift_of(rest, {{0, 0, 0}, {0.1, 0.1, -0.01}}).at(0).value, 0.01, 1e-12);
  const Contact rail{.name = "rail", .kind = ContactKind::planar};
  EXPECT_TRUE(drift_of(rail, {{0, 0, 0}, {0, 0.1, 0}}).empty());
  EXPECT_NEAR(drift_of(rail, {{0, 0, 0}, {0.003, 0.1, -0.004}}).at(0).value, 0.005, 1e-12);
}

// A floating block rotated by 90° about y: its z axis is the world's x axis.
TEST(Drift, DirectionInFrameAxesTurnsWithFrame) {
  const std::string body =
      R"(<robot name="box"><link name="box"><inertial><mass value="1"/>)"
      R"(<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>)";
  const auto robot = std::make_shared<const RobotModel>(
      parse_urdf(body, "box.urdf", {.base = UrdfOptions::Base::floating}).model.value());
  const auto drift_along_x = [&](FrameAxes axes) {
    const auto system =
        std::make_shared<MultibodySystem>(robot, Actuation::full(*robot), PassiveForces{},
                                          std::vector<Contact>{{.name = "rest",
                                                                .frame = *robot->find_frame("box"),
                                                                .kind = ContactKind::normal,
                                                                .axes = axes}});
    std::vector<double> start(13, 0.0);
    start[4] = start[6] = std::sqrt(0.5);
    const ShootingProblem problem = testing::tracking_problem(
        system, Integrator::semi_implicit_euler, 1, 0.1, start,
        {.goal = start, .q = std::vector<double>(12, 1.0), .qf = std::vector<double>(12, 1.0)});
    Trajectory motion = problem.create_trajectory();
    motion.x(1)[0] = 0.01;
    return found_in_contacts(problem, motion, FindingKind::drift).size();
  };
  EXPECT_EQ(drift_along_x(FrameAxes::local), 1u);
  EXPECT_EQ(drift_along_x(FrameAxes::world_aligned), 0u);
}

TEST(Drift, RestartsWithEachStance) {
  const auto held = block_system({{.name = "grip"}}), loose = block_system();
  const ShootingProblem problem =
      block_problem({block_phase(held, 2), block_phase(loose, 1), block_phase(held, 2)});
  Trajectory motion = problem.create_trajectory();
  const double along_x[] = {0, 0, 0.002, 0.2, 0.203, 0.203};
  for (int k = 0; k <= 5; ++k) motion.x(k)[0] = along_x[k];
  const auto found = found_in_contacts(problem, motion, FindingKind::drift);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].value, 0.003, 1e-12);
  EXPECT_EQ(found[0].knot, 4);
  EXPECT_TRUE(mentions(found[0], "from 0.3 s to 0.5 s")) << found[0].message;
}

TEST(RedundantContacts, AreRowsBeyondTheIndependentOnes) {
  const ShootingProblem problem = block_problem(
      {block_phase(block_system({{.name = "grip"}}), 2),
       block_phase(block_system({{.name = "grip"}, {.name = "rest", .kind = ContactKind::normal}}),
                   2)});
  const auto found =
      found_in_contacts(problem, problem.create_trajectory(), FindingKind::redundant_contacts);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].value, 1);
  EXPECT_EQ(found[0].knot, 2);
  EXPECT_TRUE(mentions(found[0], "of all 4 rows 3 are independent")) << found[0].message;
  const ShootingProblem from_the_start = block_problem({block_phase(
      block_system({{.name = "grip"}, {.name = "rest", .kind = ContactKind::normal}}), 2)});
  const auto first = found_in_contacts(from_the_start, from_the_start.create_trajectory(),
                                       FindingKind::redundant_contacts);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].knot, 0);
}

}  // namespace
}  // namespace conddp
