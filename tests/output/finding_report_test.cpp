// Findings of motions: reported where they occur, and only there.
#include "output/solution/finding_report.hpp"

#include <cstdio>
#include <filesystem>
#include <limits>

#include <gtest/gtest.h>

#include "output/solution/solution.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

class Findings : public testing::Test {
 protected:
  void load(const std::string& name, const std::vector<std::string>& settings = {}) {
    Diagnostics out;
    const auto file = source_tree() / "problems" / (name + ".yaml");
    spec_ = read_problem(file, settings, out);
    ASSERT_TRUE(spec_) << format_diagnostics(out, false);
    built_ = build_problem(*spec_, {}, out);
    ASSERT_TRUE(built_) << format_diagnostics(out, false);
  }
  void load_text(const std::string& text) {
    Diagnostics out;
    spec_ = read_problem_text(text, "text.yaml", {}, out);
    ASSERT_TRUE(spec_) << format_diagnostics(out, false);
    built_ = build_problem(*spec_, {}, out);
    ASSERT_TRUE(built_) << format_diagnostics(out, false);
  }
  SolveResult solved() const {
    return solve(*built_->problem, spec_->solver.name.value, spec_->solver.options, built_->guess);
  }
  std::vector<Finding> of(FindingKind kind, const Trajectory& trajectory) const {
    std::vector<Finding> list;
    for (Finding& f :
         findings_of(*built_, trajectory, no_gains(), NodeValues(*built_->problem, trajectory)))
      if (f.kind == kind) list.push_back(std::move(f));
    return list;
  }
  std::vector<Eigen::MatrixXd> no_gains() const { return Feedback(*built_->problem).K; }
  int joint(const std::string& name) const {
    const int index = *built_->plant.robot().find_joint(name);
    return *built_->plant.multibody()->position_index(index);
  }

  std::optional<ProblemSpec> spec_;
  std::optional<BuiltProblem> built_;
};

// A rate of 1/ms with steps of 10 ms: what the log advises would not help.
TEST_F(Findings, AdviseTheDiagnosisIfStepsAreUnstable) {
  load_text(R"(conddp: 1
system: {states: {i: A}, controls: {u: V}, rate: {i: 1000*(u - i)}}
initial_state: {values: {i: 1}}
integrator: rk4
phases: [{name: on, knots: 5, dt: 0.01}]
costs: {effort: {residual: control}}
solver: {name: ddp}
)");
  SolveResult failed(*built_->problem);
  failed.status = SolveStatus::line_search_failed;
  failed.trajectory = built_->guess;
  const Answer answer(*built_, failed);
  const auto stiff = of(FindingKind::unstable_steps, failed.trajectory);
  ASSERT_EQ(stiff.size(), 1u);
  EXPECT_NE(stiff[0].remedy, "");
  EXPECT_EQ(answer.diagnosis.remedy, stiff[0].remedy);
}

// A table of drag up to speed 3, read by the rates and, in the second phase, by a cost.
TEST_F(Findings, NamesTablesReadBeyondTheirPoints) {
  load_text(R"(conddp: 1
tables:
  d: {points: [0, 1, 3], values: [0, 1, 2]}
  e: {points: [-1, 0], values: [2, 3]}
system: {states: {x: m}, controls: {u: m/s}, rate: {x: u - d(x)}}
initial_state: {values: {x: 1}}
phases: [{name: first, knots: 4, dt: 0.1}, {name: second, knots: 2, dt: 0.1}]
costs:
  effort: {residual: control}
  late: {residual: expression, rows: e(u) + x, phases: second}
  unused: {residual: expression, rows: e(9 + x), weight: 0}
solver: {name: ddp}
)");
  Trajectory motion = built_->problem->create_trajectory();
  const double states[] = {1, 3, 3.5, 4.43, 3.1, 2, 7};
  for (int k = 0; k <= 6; ++k) motion.x(k)[0] = states[k];
  for (int k = 0; k < 6; ++k) motion.u(k)[0] = k == 5 ? -1.5 : -0.5;
  motion.u(0)[0] = 5;
  const auto found = of(FindingKind::table_range, motion);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].subject, "d");
  EXPECT_EQ(found[0].knot, 3);
  EXPECT_NEAR(found[0].value, 1.43, 1e-12);
  EXPECT_EQ(found[0].message,
            "the table 'd' is read at 4.43, beyond its last point 3, at knots 2 to 4");
  EXPECT_EQ(found[1].message,
            "the table 'e' is read at -1.5, beyond its first point -1, at knot 5");
  for (int k = 0; k <= 6; ++k) motion.x(k)[0] = 2;
  motion.u(5)[0] = -1;
  EXPECT_TRUE(of(FindingKind::table_range, motion).empty());
}

// Feet touch down with some speed; the default kd of 20 removes it only over many steps.
TEST_F(Findings, AdvisedKdCuresTheDriftOfFeet) {
  load("quadruped_trot", {"contacts.defaults.baumgarte.kd=20"});
  const auto drifts = of(FindingKind::drift, solved().trajectory);
  ASSERT_EQ(drifts.size(), 4u);
  EXPECT_GT(drifts.front().value, 6e-3);
  double advised = 0;
  for (const Finding& f : drifts) {
    double kd = 0;
    ASSERT_EQ(std::sscanf(f.remedy.c_str(),
                          ("contacts." + f.subject + ".baumgarte: {kd: %lf}").c_str(), &kd),
              1)
        << f.remedy;
    advised = std::max(advised, kd);
  }
  load("quadruped_trot", {"contacts.defaults.baumgarte.kd=" + std::to_string(advised)});
  const auto left = of(FindingKind::drift, solved().trajectory);
  EXPECT_TRUE(left.empty()) << left.front().message;
}

TEST_F(Findings, DoesNotAdviseLimitsTheFileBounds) {
  const auto remedy = [&](const std::vector<std::string>& settings) {
    load("arm_reach", settings);
    Trajectory motion = built_->guess;
    const Joint& elbow = built_->plant.robot().joints[3];
    motion.x(4)[built_->problem->nx() / 2 + joint(elbow.name)] = elbow.max_velocity + 0.5;
    return of(FindingKind::velocity_limit, motion).at(0).remedy;
  };
  EXPECT_EQ(remedy({}), "constraints: {NAME: {bounds: velocity, from: urdf}}");
  EXPECT_EQ(remedy({"constraints.v={bounds: velocity, from: urdf}"}), "");
  EXPECT_NE(remedy({"constraints.v={bounds: configuration, from: urdf}"}), "");
}

TEST_F(Findings, WatchesUrdfLimitsByDefault) {
  load("arm_reach");
  Trajectory motion = built_->guess;
  EXPECT_TRUE(of(FindingKind::position_limit, motion).empty());
  const Joint& elbow = built_->plant.robot().joints[3];
  const int q = joint(elbow.name);
  motion.x(7)[q] = elbow.upper + 0.25;
  motion.x(9)[q] = elbow.upper + 0.1;
  motion.x(4)[built_->problem->nx() / 2 + q] = -elbow.max_velocity - 0.5;
  motion.u(3)[3] = elbow.max_effort;
  motion.u(5)[2] = -built_->plant.robot().joints[2].max_effort - 3;
  const auto position = of(FindingKind::position_limit, motion);
  ASSERT_EQ(position.size(), 1u);
  EXPECT_EQ(position[0].subject, elbow.name);
  EXPECT_NEAR(position[0].value, 0.25, 1e-12);
  EXPECT_EQ(position[0].knot, 7);
  const auto velocity = of(FindingKind::velocity_limit, motion);
  ASSERT_EQ(velocity.size(), 1u);
  EXPECT_NEAR(velocity[0].value, 0.5, 1e-12);
  EXPECT_EQ(velocity[0].knot, 4);
  const auto effort = of(FindingKind::effort_limit, motion);
  ASSERT_EQ(effort.size(), 2u);
  EXPECT_NEAR(effort[0].value, 3, 1e-12);
  EXPECT_EQ(effort[0].unit, "Nm");
  EXPECT_NEAR(effort[1].value, built_->problem->times()[1], 1e-12) << "s at the limit";
  EXPECT_EQ(effort[1].unit, "s");
}

TEST_F(Findings, ReportsNeededFrictionAndPulls) {
  load("quadruped_stand", {"contacts.defaults.friction=0.001"});
  Trajectory motion = built_->guess;
  const auto demand = of(FindingKind::friction_demand, motion);
  ASSERT_FALSE(demand.empty());
  EXPECT_GT(demand[0].value, 0.001);
  EXPECT_NE(demand[0].message.find("0.001 is what it has"), std::string::npos);
  EXPECT_TRUE(of(FindingKind::pull, motion).empty());
  for (int k = 0; k < built_->problem->knots(); ++k) motion.u(k) *= -1;
  EXPECT_FALSE(of(FindingKind::pull, motion).empty());
}

// Nodes on both sides of a disc satisfy its constraint.
TEST_F(Findings, FindsPenetrationBetweenKnots) {
  load("unicycle_obstacles");
  Trajectory motion = built_->guess;
  const ConstraintTerm& disc = built_->problem->knot(0).model->constraints().front();
  const double* parameters = built_->problem->knot(0).parameters;
  const double cx = parameters[disc.parameters], cy = parameters[disc.parameters + 1];
  for (int k = 0; k <= built_->problem->knots(); ++k) {
    motion.x(k)[0] = cx + (k < 20 ? -5 : 5);
    motion.x(k)[1] = cy;
  }
  const auto between = of(FindingKind::between_knots, motion);
  ASSERT_FALSE(between.empty());
  EXPECT_EQ(between[0].knot, 19);
  EXPECT_GT(between[0].value, 0.1);
}

TEST_F(Findings, NamesThePairThatViolatesADistance) {
  load("arm_maze");
  Trajectory motion = built_->guess;
  const auto is_distance = [](const Finding& f) { return f.unit == "m"; };
  EXPECT_TRUE(std::ranges::none_of(of(FindingKind::constraint_row, motion), is_distance));
  motion.x(11).setZero();
  motion.x(11)[1] = 0.4;
  const auto found = of(FindingKind::constraint_row, motion);
  const auto pair = std::ranges::find_if(found, is_distance);
  ASSERT_NE(pair, found.end());
  EXPECT_EQ(pair->knot, 11);
  EXPECT_NE(pair->subject.find("-"), std::string::npos) << pair->subject;
  EXPECT_NE(pair->message.find("'clear' is violated by"), std::string::npos);
}

TEST_F(Findings, FindsAJumpInTheLastStep) {
  load("pendulum_swingup");
  Trajectory motion = built_->guess;
  const int N = built_->problem->knots();
  EXPECT_TRUE(of(FindingKind::last_knot, motion).empty());
  motion.u(N - 1)[0] = 2;
  const auto jumps = of(FindingKind::last_knot, motion);
  ASSERT_EQ(jumps.size(), 1u);
  EXPECT_EQ(jumps[0].knot, N - 1);
  EXPECT_NEAR(jumps[0].value, 1.9, 1e-12);
}

TEST_F(Findings, NamesThrustersThatCannotTurnABody) {
  load("body_reorient");
  EXPECT_TRUE(of(FindingKind::thrusters, built_->guess).empty());
  load("body_reorient",
       {"robot.actuation.thrusters=[{name: up, frame: body, direction: [0, 0, 1]}, {name: down, "
        "frame: body, direction: [0, 0, -1], torque_ratio: 0.1}]",
        "constraints={}"});
  const auto found = of(FindingKind::thrusters, built_->guess);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].value, 2);
  EXPECT_NE(found[0].message.find("its axes x, y"), std::string::npos) << found[0].message;
}

TEST_F(Findings, SaysNothingAboutNonFiniteMotions) {
  load("arm_reach");
  Trajectory motion = built_->guess;
  motion.x(3)[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(
      findings_of(*built_, motion, no_gains(), NodeValues(*built_->problem, motion)).empty());
}

TEST(FindingLines, ShowTheWorstThreeOfAKind) {
  std::vector<Finding> list(5);
  for (Finding& f : list) f = {.message = "m", .remedy = "r"};
  list.push_back({.kind = FindingKind::drift, .knot = 4, .time = 0.5, .message = "d"});
  EXPECT_EQ(
      finding_lines(list),
      (std::vector<std::string>{"m; try r", "m", "m", "and 2 more of the kind 'position_limit'",
                                "d (knot 4, 0.5 s)"}));
  EXPECT_TRUE(finding_lines({}).empty());
}

}  // namespace
}  // namespace conddp
