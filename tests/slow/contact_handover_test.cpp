// Contact-implicit motions; DDP solvers refine their extracted schedules.
#include <fstream>

#include <gtest/gtest.h>

#include "output/schedule/contact_schedule.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/yaml/yaml_text.hpp"
#include "support/solved_example.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// A hop of 0.8 m from rest within 1.2 s, with a stationary guess.
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

/// A block falls on a box while pushed sideways.
constexpr const char* kBox = R"(conddp: 1
name: box
robot: {urdf: robots/block.urdf, actuation: {joints: [base_x]}}
initial_state: {joints: {base_x: 2, base_z: 0.8}}
contact_candidates:
  rear: {frame: corner_1, friction: 0.5,
         against: {box: {size: [4, 1, 0.4], placement: {position: [2, 0, 0]}}}}
  front: {frame: corner_2, friction: 0.5,
          against: {box: {size: [4, 1, 0.4], placement: {position: [2, 0, 0]}}}}
stepping: {plane: [0, 1, 0]}
phases: [{name: fall, knots: 16, dt: 0.02}]
costs: {effort: {residual: control, weight: 1.0e-2}}
terminal:
  constraints:
    there: {residual: joint_position, joints: [base_x], reference: 2.1}
    rest: {residual: joint_velocity, joints: [base_x]}
solver: {name: ipopt}
)";

/// A block falls with one corner onto a ball; a torque keeps it level.
constexpr const char* kBall = R"(conddp: 1
name: ball
robot: {urdf: robots/block.urdf, actuation: {joints: [base_x, base_pitch]}}
initial_state: {joints: {base_z: 0.6}}
contact_candidates:
  corner: {frame: corner_1, friction: 0.5, against: {sphere: {radius: 1, center: [-0.5, 0, -1]}}}
stepping: {plane: [0, 1, 0]}
phases: [{name: fall, knots: 20, dt: 0.02}]
costs: {effort: {residual: control, weight: 1.0e-2}}
terminal: {constraints: {there: {residual: state, reference: {joints: {base_z: 0.5}}}}}
solver: {name: ipopt}
)";

/// A wheel is pulled and rolls.
constexpr const char* kWheel = R"(conddp: 1
name: wheel
robot: {urdf: robots/block.urdf, actuation: {joints: [base_x]}}
initial_state: {joints: {base_z: 0.3}}
contact_candidates: {rim: {frame: body, radius: 0.3, friction: 0.8}}
stepping: {plane: [0, 1, 0]}
phases: [{name: roll, knots: 20, dt: 0.02}]
costs: {effort: {residual: control, weight: 1.0e-2}}
terminal: {constraints: {there: {residual: joint_position, joints: [base_x], reference: 0.1}}}
solver: {name: ipopt}
)";

/// Each solver solves and certifies the phase-based problem made from an answer.
class HandOver {
 public:
  explicit HandOver(const SolvedExample& answer)
      : answer_(answer),
        motion_(*contact_motion(*answer.built.problem, answer.result->trajectory)) {
    EXPECT_EQ(answer.result->status, SolveStatus::converged) << answer.result->message;
    const ContactCertificate found = certify_contacts(motion_);
    EXPECT_LE(found.measures.complementarity.value, 1e-6);
    EXPECT_LE(found.measures.penetration.value, 1e-6);
  }
  const ContactMotion& motion() const { return motion_; }

  void expect_refined(const char* name) {
    const SolverInfo& solver = *find_solver(name);
    ScheduleOptions options{.solver = name,
                            .supports_constraints = solver.constraints == ConstraintSupport::all,
                            .folder = folder_.path()};
    options.solution = options.folder / (answer_.spec.name.value + "_solution.json");
    std::ofstream(options.solution) << answer_.document.dump();
    problem = contact_schedule(answer_.built, motion_, options).problem;
    Diagnostics out;
    const auto spec =
        read_problem_text(yaml_text(problem), options.folder / "refined.yaml", {}, out);
    ASSERT_TRUE(spec) << format_diagnostics(out, false);
    const auto built = build_problem(*spec, {}, out);
    ASSERT_TRUE(built) << format_diagnostics(out, false);
    refined.emplace(solve(*built->problem, solver, spec->solver.options, built->guess));
    EXPECT_EQ(refined->status, SolveStatus::converged) << name << ": " << refined->message;
    const auto document = OrderedJson::parse(solution_json({*built, solver, *refined, {}}).dump());
    EXPECT_EQ(failures(certify_solution(document, *built, false)), "") << name;
  }

  OrderedJson problem;                 ///< of the last schedule
  std::optional<SolveResult> refined;  ///< and its answer

 private:
  const TemporaryFolder folder_;
  const SolvedExample& answer_;
  ContactMotion motion_;
};

TEST(ContactHandOver, RefinesTheHoppersSequence) {
  const SolvedExample hop(ProblemText{kHop});
  HandOver hand_over(hop);
  bool flies = false;
  for (const ContactStretch& stretch : contact_sequence(hand_over.motion()))
    flies |= stretch.closed == std::vector<bool>{false, false};
  EXPECT_TRUE(flies);
  for (const char* solver : {"proxddp", "box_fddp"}) hand_over.expect_refined(solver);
}

TEST(ContactHandOver, BlockLandsOnABox) {
  const SolvedExample box(ProblemText{kBox});
  HandOver hand_over(box);
  hand_over.expect_refined("box_fddp");
  ASSERT_TRUE(hand_over.refined);
  const OrderedJson& obstacles = hand_over.problem["collision"]["obstacles"];
  ASSERT_TRUE(obstacles.contains("front_obstacle_face_5"));
  EXPECT_EQ(obstacles["front_obstacle_face_5"]["half_space"]["normal"],
            (OrderedJson{0.0, 0.0, 1.0}));
  const Trajectory& refined = hand_over.refined->trajectory;
  EXPECT_NEAR(refined.x(refined.knots())[0], 2.1, 1e-2);
  EXPECT_NEAR(refined.x(refined.knots())[1], 0.7, 2e-2);
}

TEST(ContactHandOver, FrictionlessBoxHoldsAlongItsNormal) {
  std::string text = kBox;
  for (std::size_t at; (at = text.find("friction: 0.5")) != std::string::npos;)
    text.replace(at, 13, "friction: 0");
  const SolvedExample box(ProblemText{text});
  HandOver hand_over(box);
  hand_over.expect_refined("box_fddp");
  EXPECT_TRUE(hand_over.problem["contacts"].contains("front_normal"));
  EXPECT_FALSE(hand_over.problem["contacts"].contains("front"));
}

TEST(ContactHandOver, BlockRestsOnABall) {
  const SolvedExample ball(ProblemText{kBall});
  HandOver hand_over(ball);
  hand_over.expect_refined("box_fddp");
  ASSERT_TRUE(hand_over.refined);
  const OrderedJson& normal = hand_over.problem["contacts"]["corner"]["normal"];
  EXPECT_NEAR(normal[2].get<double>(), 1, 1e-3);
  EXPECT_TRUE(hand_over.problem["collision"]["obstacles"]["corner_obstacle"].contains("sphere"));
  const Trajectory& refined = hand_over.refined->trajectory;
  EXPECT_NEAR(refined.x(refined.knots())[1], 0.5, 1e-2);
}

TEST(ContactHandOver, RollingWheelMayContinue) {
  const SolvedExample wheel(ProblemText{kWheel});
  HandOver hand_over(wheel);
  hand_over.expect_refined("proxddp");
  ASSERT_TRUE(hand_over.refined);
  EXPECT_EQ(hand_over.problem["contacts"]["rim_normal"]["type"], "normal");
  const Trajectory& refined = hand_over.refined->trajectory;
  EXPECT_NEAR(refined.x(refined.knots())[0], 0.1, 1e-6);
}

TEST(ContactHandOver, NamesContactsThatScheduledOnesCannotExpress) {
  for (const auto& [name, reason] :
       {std::pair{"cartpole_walls", "is soft: contacts of a schedule are rigid"},
        std::pair{"finger_spinner", "is with a body of the robot"}}) {
    const SolvedExample answer(name);
    try {
      HandOver(answer).expect_refined("box_fddp");
      ADD_FAILURE() << "a schedule of " << name;
    } catch (const NoSchedule& none) {
      EXPECT_NE(std::string(none.what()).find(reason), std::string::npos) << none.what();
    }
  }
}

/// A free initial state stays free, and the last state stays linked to it.
TEST(ContactHandOver, PeriodicGaitStaysPeriodic) {
  const SolvedExample gait("raibert_gait");
  HandOver hand_over(gait);
  const ContactMotion& motion = hand_over.motion();
  EXPECT_EQ(motion.steps(), 20);
  EXPECT_EQ(motion.first_knot, 1);
  EXPECT_NEAR(motion.q[20][0] - motion.q[0][0], 0.5, 1e-9);
  EXPECT_LT((motion.q[20] - motion.q[0]).tail(3).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((motion.v[20] - motion.v[0]).cwiseAbs().maxCoeff(), 1e-9);
  const ContactCertificate found = certify_contacts(motion);
  EXPECT_GE(found.sequence.size(), 2u) << "it touches the ground and leaves it";
  EXPECT_LE(found.measures.stepping.value, 1e-9);
  EXPECT_LE(found.measures.penetration.value, 1e-9);
  hand_over.expect_refined("proxddp");
}

}  // namespace
}  // namespace conddp
