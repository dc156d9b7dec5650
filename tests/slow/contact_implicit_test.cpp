// Contact-implicit motions, compared with mechanics.
#include <algorithm>

#include "robot/kinematics.hpp"
#include "solvers/common/guess.hpp"
#include "support/random_numbers.hpp"
#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

using testing::ReadyProblem;

constexpr double kMinForm = 1e-6;

SolveResult solve_ready(const ReadyProblem& ready) {
  return solve(*ready.built.problem, "ipopt", ready.spec.solver.options, ready.built.guess);
}

/// First knot with nonzero duration.
int first_step(const ReadyProblem& ready) {
  return ready.built.problem->phases().front().instant ? 1 : 0;
}

/// Largest |min(z, s)| of all pairs and largest penetration at the knots, measured on the robot.
void expect_exact_contacts(const ReadyProblem& ready, const SolveResult& result) {
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  const SteppingSystem& system = *ready.built.plant.stepping();
  RobotData<double> data(system.multibody().robot());
  for (int k = first_step(ready); k < result.trajectory.knots(); ++k) {
    for (const auto& [z, s] : system.layout().pairs)
      EXPECT_LE(std::abs(std::min(result.trajectory.u(k)[z], result.trajectory.u(k)[s])), kMinForm)
          << system.layout().columns[z].name << " at knot " << k;
    update_placements(system.multibody().robot(), result.trajectory.x(k + 1).data(), data);
    for (std::size_t c = 0; c < system.geometry().size(); ++c) {
      if (system.contacts().candidates[c].stiffness) continue;  // soft: allowed to yield
      const CandidateGeometry& geometry = system.geometry()[c];
      auto rows = geometry.create_rows<double>();
      geometry.evaluate(data, rows);
      EXPECT_GE(rows.gap, -kMinForm) << "knot " << k + 1;
    }
  }
}

double last(const SolveResult& result, int coordinate) {
  return result.trajectory.x(result.trajectory.knots())[coordinate];
}

TEST(BlockOnASlope, StaysUnderAForceBelowTheLimit) {
  const ReadyProblem ready("block_slope", {"constraints.force.upper=1.7"});
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  EXPECT_NEAR(last(result, 0), 0, 1e-5);
}

TEST(BlockOnASlope, SlidesUnderAForceAboveTheLimit) {
  const double weight = 9.81, slope = 0.3, friction = 0.5, push = 2.5;
  const ReadyProblem ready("block_slope");
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  // Implicit Euler steps at constant acceleration: h² a N (N + 1)/2.
  const double a = push + weight * (std::sin(slope) - friction * std::cos(slope));
  EXPECT_GT(a, 0);
  EXPECT_NEAR(last(result, 0), 0.02 * 0.02 * a * 50 * 51 / 2, 1e-3);
}

TEST(BlockOnASlope, InnerProductFindsTheSame) {
  const ReadyProblem ready("block_slope", {"solver.complementarity.relaxation=inner_product"});
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  EXPECT_EQ(result.log.back().fallbacks, 0);
  EXPECT_NEAR(result.cost, solve_ready(ReadyProblem("block_slope")).cost, 1e-5);
}

TEST(BlockOnASlope, RestartsAreReproducibleAndNeverWorse) {
  const std::vector<std::string> settings = {"solver.restarts.count=1", "solver.restarts.seed=3",
                                             "solver.restarts.spread=0.01"};
  const SolveResult first = solve_ready(ReadyProblem("block_slope", settings));
  const SolveResult second = solve_ready(ReadyProblem("block_slope", settings));
  EXPECT_EQ(first.status, SolveStatus::converged) << first.message;
  EXPECT_EQ(first.cost, second.cost);
  EXPECT_LE(first.cost, solve_ready(ReadyProblem("block_slope")).cost + 1e-9);
}

/// Example problems from their guesses, and from one with random numbers added to the controls.
class FindsItsContacts
    : public ::testing::TestWithParam<std::tuple<std::string, std::optional<int>>> {};

TEST_P(FindsItsContacts, Exactly) {
  const auto& [name, seed] = GetParam();
  const ReadyProblem ready(name);
  Trajectory start = ready.built.guess;
  if (seed) {
    RandomNumbers random(*seed);
    const int actuators = ready.built.plant.stepping()->layout().actuators;
    for (int k = first_step(ready); k < start.knots(); ++k)
      for (int i = 0; i < actuators; ++i) start.u(k)[i] += random.uniform(-0.1, 0.1);
  }
  const SolveResult result = solve(*ready.built.problem, "ipopt", ready.spec.solver.options, start);
  expect_exact_contacts(ready, result);
}

std::string case_name(const ::testing::TestParamInfo<FindsItsContacts::ParamType>& info) {
  const auto& [name, seed] = info.param;
  return name + (seed ? "_seed_" + std::to_string(*seed) : "");
}

INSTANTIATE_TEST_SUITE_P(
    Ready, FindsItsContacts,
    ::testing::Combine(
        ::testing::Values("block_slope", "block_drag", "cartpole_friction", "cartpole_walls",
                          "push_box", "finger_spinner", "acrobot_limits", "planar_biped_gait",
                          "planar_quadruped_gait"),
        ::testing::Values(std::optional<int>(), std::optional<int>(1), std::optional<int>(2))),
    case_name);

/// The same from guesses with perturbed states and controls, as 'conddp bench --perturb guess=0.01
/// --instances 2' creates them.
class FindsItsContactsFromARandomGuess
    : public ::testing::TestWithParam<std::tuple<std::string, int>> {};

TEST_P(FindsItsContactsFromARandomGuess, Exactly) {
  const auto& [name, seed] = GetParam();
  const ReadyProblem ready(name);
  const ShootingProblem& problem = *ready.built.problem;
  expect_exact_contacts(ready, solve(problem, "ipopt", ready.spec.solver.options,
                                     perturb_guess(problem, ready.built.guess, 0.01, seed)));
}

INSTANTIATE_TEST_SUITE_P(
    Ready, FindsItsContactsFromARandomGuess,
    ::testing::Combine(::testing::Values("block_slope", "block_drag", "push_box",
                                         "cartpole_friction", "cartpole_walls", "finger_spinner",
                                         "acrobot_limits", "raibert_gait", "footed_hopper",
                                         "push_obstacle", "puck_slide", "planar_biped_gait",
                                         "planar_quadruped_gait", "crate_tumble", "quadruped_hop"),
                       ::testing::Values(1, 2)),
    [](const auto& test) {
      return std::get<0>(test.param) + "_seed_" + std::to_string(std::get<1>(test.param));
    });

TEST(AcrobotBetweenStops, SwingsHigherWithLosslessSteps) {
  const SolveResult damped = solve_ready(ReadyProblem("acrobot_limits"));
  const ReadyProblem midpoint("acrobot_limits", {"stepping.scheme=variational_midpoint"});
  const SolveResult kept = solve_ready(midpoint);
  expect_exact_contacts(midpoint, kept);
  EXPECT_LT(kept.cost, damped.cost);
}

TEST(PushedBox, Moves) {
  const SolveResult result = solve_ready(ReadyProblem("push_box"));
  EXPECT_GT(last(result, 0), 0.3);
}

TEST(FootedHopper, LeavesTheGroundAndArrives) {
  const ReadyProblem ready("footed_hopper");
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  EXPECT_NEAR(last(result, 0), 4, 0.01);
  EXPECT_NEAR(last(result, 1), 1.5, 0.01);
  const auto& candidates = ready.built.plant.stepping()->layout().candidates;
  int flying = 0;
  for (int k = 0; k < result.trajectory.knots(); ++k)
    flying += std::all_of(candidates.begin(), candidates.end(), [&](const auto& c) {
      return result.trajectory.u(k)[c.gap] > 1e-3 && result.trajectory.u(k)[c.force] < 1e-6;
    });
  EXPECT_GE(flying, 5);
}

/// Foot statistics over a cycle.
struct Steps {
  int in_the_air = 0;      ///< knots
  int lifts = 0;           ///< times it leaves the ground; the first knot follows the last
  double highest = 0;      ///< m
  double slid = 0;         ///< m, while touching the ground
  double borne_there = 0;  ///< largest normal force meanwhile, N
};

Steps steps_of(const ReadyProblem& ready, const SolveResult& result,
               const SteppingLayout::Candidate& foot) {
  constexpr double kOff = 1e-5, kSlides = 1e-3;  // m, m/s
  Steps steps;
  const int last = result.trajectory.knots() - 1, first = first_step(ready);
  const auto gap = [&](int k) { return result.trajectory.u(k)[foot.gap]; };
  for (int k = first; k <= last; ++k) {
    const auto u = result.trajectory.u(k);
    steps.highest = std::max(steps.highest, gap(k));
    if (gap(k) > kOff) {
      ++steps.in_the_air;
      steps.lifts += gap(k == first ? last : k - 1) <= kOff;
      continue;
    }
    const double slip = 0.5 * (u[foot.friction.slip[0]] - u[foot.friction.slip[1]]);
    steps.slid += std::abs(slip) * ready.built.problem->knot(k).dt;
    if (std::abs(slip) > kSlides) steps.borne_there = std::max(steps.borne_there, u[foot.force]);
  }
  return steps;
}

/// Expects that every foot of a gait lifts once per cycle, reaches `height` (m), and stays in the
/// air for at least `in_the_air` knots. It slides at most `slid` meters while carrying at most
/// `borne` newtons.
void expect_steps(const std::string& gait, int in_the_air, double height, double slid,
                  double borne) {
  const ReadyProblem ready(gait);
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  for (const auto& foot : ready.built.plant.stepping()->layout().candidates) {
    const Steps steps = steps_of(ready, result, foot);
    EXPECT_EQ(steps.lifts, 1);
    EXPECT_GE(steps.in_the_air, in_the_air);
    EXPECT_GE(steps.highest, height - 1e-6);
    EXPECT_LT(steps.slid, slid);
    EXPECT_LE(steps.borne_there, borne);
  }
}

TEST(PlanarBiped, StepsAndDoesNotSlide) { expect_steps("planar_biped_gait", 5, 0.05, 1e-3, 0); }

/// Diagonal pairs alternate. Hind feet slide one step before they lift, under little load.
TEST(PlanarQuadruped, TrotsAndHardlySlides) {
  expect_steps("planar_quadruped_gait", 8, 0.03, 0.03, 0.2 * 11.6 * 9.81);
}

/// A crate of 1 kg rests on its lower corners; only friction decelerates it.
TEST(Crate, RestsAndSlidesByMechanics) {
  const double h = 0.025, friction = 0.5, speed = 1;
  const std::string start = "initial_state.velocity.base.linear=[";
  for (const double v : {0.0, speed}) {
    const ReadyProblem ready("crate_tumble",
                             {start + std::to_string(v) + ", 0, 0]", "initial_guess.states=initial",
                              "solver.complementarity.initial=0.01",
                              "constraints.pull={bounds: control, lower: 0, upper: 0}"});
    const SolveResult result = solve_ready(ready);
    expect_exact_contacts(ready, result);
    for (int k = 0; k < result.trajectory.knots(); ++k) {
      double normal = 0;
      for (const auto& c : ready.built.plant.stepping()->layout().candidates)
        normal += result.trajectory.u(k)[c.force];
      EXPECT_NEAR(normal, 9.81, 1e-5) << k;
      EXPECT_NEAR(result.trajectory.x(k + 1)[7], std::max(0.0, v - (k + 1) * h * friction * 9.81),
                  1e-5)
          << k;
      EXPECT_NEAR(result.trajectory.x(k + 1)[2], 0.1, 1e-6) << k;
    }
  }
}

TEST(Crate, IsTippedOverAnEdge) {
  const ReadyProblem ready("crate_tumble");
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  const auto end = result.trajectory.x(result.trajectory.knots());
  EXPECT_NEAR(end[0], 0.3, 0.01);
  EXPECT_NEAR(std::abs(end[4]), std::sqrt(0.5), 0.01);  // a quarter turn about y
  EXPECT_NEAR(end[2], 0.1, 1e-6);
  // It is too heavy for the hand to lift: one of its edges stays on the ground most of the time.
  const auto& candidates = ready.built.plant.stepping()->layout().candidates;
  int borne = 0;
  for (int k = 0; k < result.trajectory.knots(); ++k)
    borne += std::any_of(candidates.begin(), candidates.end(),
                         [&](const auto& c) { return result.trajectory.u(k)[c.force] > 1; });
  EXPECT_GE(borne, result.trajectory.knots() / 2);
}

TEST(QuadrupedInSpace, Hops) {
  const ReadyProblem ready("quadruped_hop");
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  EXPECT_NEAR(last(result, 0), 0.2, 0.02);
  const auto& candidates = ready.built.plant.stepping()->layout().candidates;
  int flying = 0;
  for (int k = 1; k < result.trajectory.knots(); ++k)
    flying += std::all_of(candidates.begin(), candidates.end(), [&](const auto& c) {
      return result.trajectory.u(k)[c.gap] > 1e-3 && result.trajectory.u(k)[c.force] < 1e-6;
    });
  EXPECT_GE(flying, 5);
}

TEST(PushedRoundAPost, Arrives) {
  const ReadyProblem ready("push_obstacle");
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  EXPECT_NEAR(last(result, 0), 0.3, 2e-3);
  EXPECT_NEAR(last(result, 1), 0.4, 2e-3);
  EXPECT_NEAR(last(result, 2), 4.71238898038469, 2e-3);
}

/// The penalties find no answer from this first epsilon.
TEST(RelaxationFallback, TriesTheNextRelaxationOnFailure) {
  const ReadyProblem ready("block_slope",
                           {"solver.complementarity={relaxation: penalty, initial: 10}"});
  const SolveResult result = solve_ready(ready);
  expect_exact_contacts(ready, result);
  EXPECT_EQ(result.log.front().fallbacks, 0);
  EXPECT_GT(result.log.back().fallbacks, 0);
  for (std::size_t i = 1; i < result.log.size(); ++i) {
    EXPECT_GE(result.log[i].fallbacks, result.log[i - 1].fallbacks) << i;
    EXPECT_GE(result.log[i].outer, result.log[i - 1].outer) << i;
  }
}

TEST(DraggedBlock, Arrives) {
  const SolveResult result = solve_ready(ReadyProblem("block_drag"));
  EXPECT_NEAR(last(result, 0), 5, 1e-6);
}

TEST(ContactsThatAreFound, AreRejectedByAllButInteriorPoints) {
  const ReadyProblem ready("block_slope");
  for (const SolverInfo& solver : solvers()) {
    const auto reason = unsupported(solver, *ready.built.problem);
    if (solver.complementarity) {
      EXPECT_FALSE(reason) << *reason;
      continue;
    }
    ASSERT_TRUE(reason) << solver.name;
    EXPECT_EQ(reason->find(std::string(solver.name) + " does not support the"), 0u) << *reason;
    EXPECT_NE(reason->find("; supported by ipddp, ipopt"), std::string::npos) << *reason;
  }
}

}  // namespace
}  // namespace conddp
