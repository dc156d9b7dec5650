// A hopper finds its contacts; the schedule of them is refined by solvers of the DDP family.
#include <fstream>

#include <gtest/gtest.h>

#include "output/contact_schedule.hpp"
#include "problem_file/yaml_text.hpp"
#include "support/answer.hpp"

namespace conddp {
namespace {

/// A hop of 0.8 m from rest within 1.2 s, from a guess that stands still.
constexpr const char* kHop = R"(conddp: 1
name: hop
robot:
  urdf: robots/footed_hopper.urdf
  actuation: {joints: [hip, knee, ankle]}
initial_state: {joints: {base_z: 1.5, hip: 0.7227342478, knee: -1.4454684956, ankle: 2.2935305746}}
contact_candidates:
  heel: {frame: heel, friction: 1}
  toe: {frame: toe, friction: 1}
stepping: {plane: [0, 1, 0], joint_limits: urdf}
phases: [{name: hop, knots: 40, dt: 0.03}]
costs:
  effort: {residual: control, weight: 1.0e-4}
  rates: {residual: joint_velocity, weight: 1.0e-2}
terminal:
  constraints:
    there:
      residual: state
      columns: [q/base_x, q/base_z, v/base_x, v/base_z]
      reference: {joints: {base_x: 0.8, base_z: 1.5}}
solver: {name: ipopt, max_iterations: 400}
)";

/// The problem with phases that is made of an answer is solved and certified, by each solver.
void expect_refined(const Answer& answer, const ContactMotion& motion,
                    const std::vector<const char*>& solvers) {
  ScheduleOptions options;
  options.folder = ::testing::TempDir();
  options.solution = options.folder / (answer.spec.name.value + "_solution.json");
  std::ofstream(options.solution) << answer.document.dump();
  for (const char* name : solvers) {
    const SolverInfo& solver = *find_solver(name);
    options.solver = name;
    options.keeps_constraints = solver.constraints == ConstraintSupport::all;
    const ContactSchedule schedule = contact_schedule(answer.spec, answer.built, motion, options);
    Diagnostics out;
    const auto spec =
        read_problem_text(yaml_text(schedule.problem), options.folder / "refined.yaml", {}, out);
    ASSERT_TRUE(spec) << format_diagnostics(out, false);
    const auto built = build_problem(*spec, {}, out);
    ASSERT_TRUE(built) << format_diagnostics(out, false);
    const SolveResult refined = solve(*built->problem, solver, spec->solver.options, built->guess);
    EXPECT_EQ(refined.status, SolveStatus::converged) << name << ": " << refined.message;
    const auto document =
        OrderedJson::parse(solution_json({*spec, *built, solver, refined, {}}).dump());
    EXPECT_EQ(failures(certify_solution(document, *spec, *built, false)), "") << name;
  }
}

TEST(ContactHandOver, TheHoppersSequenceIsRefined) {
  const Answer hop(ProblemText{kHop});
  const auto motion = contact_motion(*hop.built.problem, hop.result->trajectory);
  ASSERT_TRUE(motion);
  const ContactCertificate found = certify_contacts(*motion);
  EXPECT_LE(found.measures.complementarity.value, 1e-6);
  EXPECT_LE(found.measures.penetration.value, 1e-6);
  bool flies = false;
  for (const ContactStretch& stretch : found.sequence)
    flies |= stretch.closed == std::vector<bool>{false, false};
  EXPECT_TRUE(flies);
  expect_refined(hop, *motion, {"proxddp", "box_fddp"});
}

/// A first state that is chosen stays one, and the link of the last state with it.
TEST(ContactHandOver, APeriodicGaitStaysPeriodic) {
  const Answer gait("raibert_gait");
  ASSERT_EQ(gait.result->status, SolveStatus::converged) << gait.result->message;
  const auto motion = contact_motion(*gait.built.problem, gait.result->trajectory);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->steps(), 20);
  EXPECT_EQ(motion->first_knot, 1);
  EXPECT_NEAR(motion->q[20][0] - motion->q[0][0], 0.5, 1e-9);
  EXPECT_LT((motion->q[20] - motion->q[0]).tail(3).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((motion->v[20] - motion->v[0]).cwiseAbs().maxCoeff(), 1e-9);
  const ContactCertificate found = certify_contacts(*motion);
  EXPECT_GE(found.sequence.size(), 2u) << "it touches the ground and leaves it";
  EXPECT_LE(found.measures.stepping.value, 1e-9);
  EXPECT_LE(found.measures.penetration.value, 1e-9);
  expect_refined(gait, *motion, {"proxddp"});
}

}  // namespace
}  // namespace conddp
