// Contact-implicit answers: the certificate holds, and fails after any change of the
// contacts.
#include <functional>

#include <gtest/gtest.h>

#include "output/report/certificate_report.hpp"
#include "output/report/contact_report.hpp"
#include "output/schedule/contact_schedule.hpp"
#include "output/schedule/softened_constraint.hpp"
#include "support/solved_example.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// A block of 1 kg is pushed 0.1 m along the ground and stops; the upper corner never touches.
constexpr const char* kPushedBlock = R"(conddp: 1
name: pushed_block
robot: {urdf: robots/block.urdf, actuation: {joints: [base_x]}}
initial_state: {joints: {base_z: 0.5}}
contact_candidates:
  rear: {frame: corner_1, friction: 0.5}
  front: {frame: corner_2, friction: 0.5}
  top: {frame: corner_3, friction: 0.5}
stepping: {plane: [0, 1, 0]}
phases: [{name: push, knots: 12, dt: 0.05}]
costs: {effort: {residual: control, weight: 1.0e-3}}
terminal:
  constraints:
    there: {residual: joint_position, joints: [base_x], reference: 0.1}
    rest: {residual: joint_velocity, joints: [base_x]}
initial_guess: {states: initial, controls: zero}
solver: {name: ipopt}
)";

const SolvedExample& pushed_block() {
  static const SolvedExample answer(ProblemText{kPushedBlock});
  return answer;
}

int column(const OrderedJson& document, const char* kind, const std::string& name) {
  const OrderedJson& names = document["trajectory"]["columns"][kind];
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return static_cast<int>(i);
  throw std::runtime_error("no column " + name);
}

OrderedJson& control(OrderedJson& document, int knot, const std::string& name) {
  return document["trajectory"]["u"][knot][column(document, "u", name)];
}

std::string failures_after(const std::function<void(OrderedJson&)>& change) {
  OrderedJson document = pushed_block().document;
  change(document);
  return failures(pushed_block().judge(document));
}

TEST(ContactSolution, CertificateHolds) {
  ASSERT_EQ(pushed_block().result->status, SolveStatus::converged)
      << pushed_block().result->message;
  const SolutionCertificate certificate = pushed_block().judge(pushed_block().document);
  EXPECT_EQ(failures(certificate), "");
  ASSERT_TRUE(certificate.contacts);
  const ContactMeasures& measures = certificate.contacts->measures;
  EXPECT_LE(measures.complementarity.value, 1e-6);
  EXPECT_LE(measures.penetration.value, 1e-6);
  // Friction work over 0.1 m, independent of the push.
  EXPECT_NEAR(measures.work_contacts, -0.5 * 9.81 * 0.1, 1e-3);
  EXPECT_NEAR(measures.energy_end, measures.energy_start, 1e-5);
}

TEST(ContactSolution, ChangedForce) {
  EXPECT_NE(failures_after([](OrderedJson& d) {
              add_to(control(d, 6, "contact/front/fn"), 1e-4);
            }).find("[contact stepping]"),
            std::string::npos);
}

TEST(ContactSolution, ForceAtADistance) {
  const std::string names =
      failures_after([](OrderedJson& d) { control(d, 6, "contact/top/fn") = 1e-3; });
  EXPECT_NE(names.find("[force at a distance]"), std::string::npos) << names;
  EXPECT_NE(names.find("[contact complementarity]"), std::string::npos) << names;
}

TEST(ContactSolution, Penetration) {
  const std::string names = failures_after([](OrderedJson& d) {
    for (std::size_t k = 3; k < d["trajectory"]["x"].size(); ++k)
      add_to(d["trajectory"]["x"][k][column(d, "x", "q/base_z")], -1e-5);
  });
  EXPECT_NE(names.find("[contact penetration]"), std::string::npos) << names;
}

TEST(ContactSolution, SignsOfForces) {
  const std::string pull =
      failures_after([](OrderedJson& d) { control(d, 6, "contact/front/fn") = -1; });
  EXPECT_NE(pull.find("[contact pull]"), std::string::npos) << pull;
  const std::string friction = failures_after([](OrderedJson& d) {
    for (const char* corner : {"contact/front", "contact/rear"})
      for (int k = 0; k < 12; ++k)
        std::swap(control(d, k, std::string(corner) + "/ft+"),
                  control(d, k, std::string(corner) + "/ft-"));
  });
  EXPECT_NE(friction.find("[contact friction]"), std::string::npos) << friction;
  EXPECT_NE(friction.find("[contact dissipation]"), std::string::npos) << friction;
}

/// An unconverged answer claims nothing about its contacts and reports their state.
TEST(ContactSolution, ClaimsNeedConvergence) {
  OrderedJson document = pushed_block().document;
  document["status"] = "max_iterations";
  control(document, 6, "contact/top/fn") = 1;
  const SolutionCertificate certificate = pushed_block().judge(document);
  EXPECT_EQ(failures(certificate).find("[contact"), std::string::npos) << failures(certificate);
  EXPECT_GT(certificate.contacts->measures.distant.value, 0.5);
}

TEST(ContactSolution, ReplayByTheSimulatorAgreesStepByStep) {
  const SolutionCertificate certificate =
      certify_solution(pushed_block().document, pushed_block().built, true);
  ASSERT_TRUE(certificate.contacts->replay);
  EXPECT_LT(certificate.contacts->replay->each_step.deviation, 1e-5);
  EXPECT_EQ(certificate.contacts->replay->each_step.lost_at, -1);
  EXPECT_LT(certificate.contacts->replay->controls.deviation, 1e-4);
  EXPECT_FALSE(certificate.replay->impossible.empty());
  const OrderedJson json = certificate_json(certificate);
  EXPECT_TRUE(json["contacts"].contains("replay"));
  EXPECT_EQ(json["contacts"]["sequence"][0]["closed"].size(), 2u);
}

TEST(ContactSchedule, AnswerBuildsAndKeepsItsCosts) {
  const auto motion =
      contact_motion(*pushed_block().built.problem, pushed_block().result->trajectory);
  ASSERT_TRUE(motion);
  ScheduleOptions options;
  options.folder = source_tree() / "problems";
  options.solution = options.folder / "solution.json";
  const ContactSchedule schedule = contact_schedule(pushed_block().built, *motion, options);
  EXPECT_EQ(schedule.problem["robot"]["urdf"], "robots/block.urdf");
  EXPECT_EQ(schedule.problem["initial_guess"]["states"]["file"], "solution.json");
  EXPECT_EQ(schedule.problem["contacts"]["front_normal"]["type"], "normal");
  EXPECT_EQ(schedule.problem["phases"][0]["contacts"].size(), 2u);
  // Accelerations alone would let them leave the surface.
  for (const char* section : {"constraints", "terminal"}) {
    const OrderedJson& terms = section == std::string("terminal")
                                   ? schedule.problem["terminal"]["constraints"]
                                   : schedule.problem["constraints"];
    ASSERT_TRUE(terms.contains("contact_held_front")) << section;
    EXPECT_EQ(terms["contact_held_front"]["residual"], "distance");
    EXPECT_EQ(terms["contact_held_front"]["lower"], -1e-3);
    EXPECT_EQ(terms["contact_held_front"]["upper"], 1e-3);
  }
  EXPECT_TRUE(schedule.problem["costs"].contains("effort"));
  EXPECT_FALSE(schedule.problem.contains("contact_candidates"));
  EXPECT_FALSE(schedule.notes.empty()) << "a sliding contact has no friction there";
}

TEST(Softened, ConstraintsBecomeCosts) {
  const OrderedJson equal =
      softened({{"residual", "state"}, {"equals", 0.0}, {"phases", {"a"}}}, 10);
  EXPECT_EQ(equal, (OrderedJson{{"residual", "state"}, {"phases", {"a"}}, {"weight", 10.0}}));
  const OrderedJson above = softened({{"residual", "distance"}, {"lower", 0.1}}, 10);
  EXPECT_EQ(above["activation"]["kind"], "quadratic_barrier");
  EXPECT_EQ(above["activation"]["lower"], 0.1);
  EXPECT_FALSE(above.contains("lower"));
  const OrderedJson stops = softened({{"bounds", "configuration"}, {"upper", {{"q/knee", 1}}}}, 10);
  EXPECT_EQ(stops["residual"], "state");
  EXPECT_EQ(stops["activation"]["upper"]["q/knee"], 1);
  EXPECT_TRUE(softened({{"residual", "state"}, {"at_least", 1}}, 10).is_null());
}

TEST(ContactCertificate, HoldsForAnswersStoppedWithEqualPairs) {
  const SolvedExample answer("puck_slide", {"solver.complementarity.relaxation=fischer_burmeister",
                                            "solver.max_iterations=20"});
  EXPECT_EQ(answer.result->status, SolveStatus::max_iterations);
  EXPECT_EQ(failures(answer.judge(answer.document)), "");
}

}  // namespace
}  // namespace conddp
