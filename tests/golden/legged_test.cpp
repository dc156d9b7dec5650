// Requirements of legged motions, measured independently of the solvers: stance feet do not slip,
// swing feet clear the ground, forces carry the weight.
#include <Eigen/Dense>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "robot/dynamics.hpp"
#include "robot/frames.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

using Data = MultibodySystem::Data<double>;

struct Solved {
  std::optional<ProblemSpec> spec;
  std::optional<BuiltProblem> built;
  std::optional<SolveResult> result;

  const Trajectory& trajectory() const { return result->trajectory; }
  const MultibodySystem& system(int k) const {
    return static_cast<const MultibodySystem&>(built->problem->knot(k).model->system());
  }
  Vector3<double> position(int k, const std::string& frame) const {
    const RobotModel& robot = built->plant.robot();
    RobotData<double> data(robot);
    update_placements(robot, trajectory().x(k).data(), data);
    return frame_placement(robot, data, *robot.find_frame(frame)).p;
  }
};

Solved solve_ready(const std::string& name) {
  Solved s;
  Diagnostics diagnostics;
  s.spec = read_problem(source_tree() / "problems" / (name + ".yaml"), {}, diagnostics);
  if (s.spec) s.built = build_problem(*s.spec, {}, diagnostics);
  EXPECT_TRUE(s.built) << format_diagnostics(diagnostics, false);
  if (s.built)
    s.result =
        solve(*s.built->problem, s.spec->solver.name.value, s.spec->solver.options, s.built->guess);
  return s;
}

/// Largest distance in m of a contact frame from its position when the contact began, while it is
/// held. A step moves the foot to the position of the next node.
double largest_slip(const Solved& s, const ContactSpec& contact) {
  Vector3<double> stood{};
  bool standing = false;
  double largest = 0;
  for (int k = 0; k < s.built->problem->knots(); ++k) {
    bool held = false;
    for (const Contact& c : s.system(k).contacts().contacts())
      held = held || c.name == contact.name.value;
    if (held && !standing) stood = s.position(k, contact.frame.value);
    standing = held;
    if (!held) continue;
    const Vector3<double> slip = s.position(k + 1, contact.frame.value) - stood;
    largest = std::max(largest, std::sqrt(squared_norm(slip)));
  }
  return largest;
}

TEST(QuadrupedTrot, AdvancesWithoutSlippingOrDragging) {
  const Solved s = solve_ready("quadruped_trot");
  ASSERT_EQ(s.result->status, SolveStatus::converged) << s.result->message;
  EXPECT_LE(s.result->residuals.gap, 1e-9);
  const int N = s.built->problem->knots();
  EXPECT_GE(s.position(N, "trunk").x - s.position(0, "trunk").x, 0.2);
  for (int k = 0; k < N; ++k) {
    const KnotModel& model = *s.built->problem->knot(k).model;
    for (int i = 0; i < model.nu(); ++i) {
      EXPECT_LE(s.trajectory().u(k)[i], model.control_upper()[i]);
      EXPECT_GE(s.trajectory().u(k)[i], model.control_lower()[i]);
    }
  }
  for (const ContactSpec& contact : s.spec->contacts) {
    const std::string& frame = contact.frame.value;
    double height = 0;
    for (int k = 0; k < N; ++k)
      height = std::max(height, s.position(k, frame).z - s.position(0, frame).z);
    EXPECT_LT(largest_slip(s, contact), 1e-3) << frame;
    EXPECT_GE(height, 0.04) << frame;
  }
}

class SteppingProblem : public ::testing::TestWithParam<std::string> {};

/// Every foot lands at the end of its swing, stays there during stance, and lifts in between.
TEST_P(SteppingProblem, FeetLandAtTheirTargetsAndStay) {
  const Solved s = solve_ready(GetParam());
  ASSERT_EQ(s.result->status, SolveStatus::converged) << s.result->message;
  const ShootingProblem& problem = *s.built->problem;
  for (const ContactSpec& contact : s.spec->contacts) {
    const std::string& frame = contact.frame.value;
    const auto held = [&](int k) {
      const auto& held_now = s.system(k).contacts().contacts();
      return std::any_of(held_now.begin(), held_now.end(),
                         [&](const Contact& c) { return c.name == contact.name.value; });
    };
    int landings = 0;
    double height = 0, missed = 0, above = 0, slip = 0;
    Vector3<double> stood = s.position(0, frame);
    Vector3<double> wanted = stood;
    for (int k = 0; k < problem.knots(); ++k) {
      const Vector3<double> p = s.position(k, frame);
      height = std::max(height, p.z - stood.z);
      const KnotView& knot = problem.knot(k);
      for (const CostTerm& term : knot.model->costs())
        if (term.name == "swing_" + contact.name.value && knot.parameters[term.weight] > 0)
          for (int i = 0; i < 3; ++i) wanted[i] = knot.parameters[term.parameters + i];
      if (!held(k)) continue;
      if (k > 0 && !held(k - 1)) {
        ++landings;
        stood = p;
        missed = std::max(missed, std::sqrt(squared_norm(stood - wanted)));
        above = std::max(above, std::abs(stood.z - wanted.z));
      }
      slip = std::max(slip, std::sqrt(squared_norm(s.position(k + 1, frame) - stood)));
    }
    EXPECT_GE(landings, 1);
    EXPECT_LT(missed, 5e-3) << frame;
    EXPECT_LT(above, 1e-3) << frame;
    // Legs that land fast, and soles, rotate on by the square of a step's angle.
    const bool trots = GetParam().starts_with("quadruped_trot");
    EXPECT_LT(slip, trots ? 1e-3 : 2e-3) << frame;
    EXPECT_GE(height, 0.04) << frame;
  }
}

INSTANTIATE_TEST_SUITE_P(Ready, SteppingProblem,
                         ::testing::Values("quadruped_trot", "quadruped_pace_turn",
                                           "quadruped_walk", "quadruped_bound", "quadruped_jump",
                                           "quadruped_trot_slope", "biped_steps", "hopper_jump"),
                         [](const auto& name) { return name.param; });

TEST(QuadrupedPaceTurn, TurnsAlongItsArc) {
  const Solved s = solve_ready("quadruped_pace_turn");
  ASSERT_EQ(s.result->status, SolveStatus::converged);
  const auto x = s.trajectory().x(s.built->problem->knots());
  // Chord of an arc of 0.3 m and 0.6 rad.
  const double chord = 0.3 * std::sin(0.3) / 0.3;
  EXPECT_NEAR(x[0], chord * std::cos(0.3), 0.005);
  EXPECT_NEAR(x[1], chord * std::sin(0.3), 0.005);
  EXPECT_NEAR(2 * std::atan2(x[5], x[6]), 0.6, 0.01);
}

TEST(QuadrupedTrot, ForcesCarryTheWeightWithinTheirCones) {
  const Solved s = solve_ready("quadruped_trot");
  ASSERT_EQ(s.result->status, SolveStatus::converged);
  for (int k = 0; k < s.built->problem->knots(); ++k) {
    const MultibodySystem& system = s.system(k);
    const auto data = system.create_data(double{});
    system.evaluate(s.trajectory().x(k).data(), s.trajectory().u(k).data(), *data);
    for (const auto& contact : static_cast<const Data&>(*data).contacts.contacts) {
      const Force<double> f = contact_force_in_world(contact);
      EXPECT_GT(f.linear.z, 0);
      EXPECT_LE(std::hypot(f.linear.x, f.linear.y), 0.7 * f.linear.z * (1 + 1e-3));
    }
  }
}

TEST(QuasiStaticGuess, StandingForcesHoldAndSumToWeight) {
  Diagnostics diagnostics;
  const auto spec = read_problem(source_tree() / "problems/quadruped_trot.yaml", {}, diagnostics);
  ASSERT_TRUE(spec);
  const auto built = build_problem(*spec, {}, diagnostics);
  ASSERT_TRUE(built);
  const auto& system = static_cast<const MultibodySystem&>(built->problem->knot(0).model->system());
  ASSERT_EQ(system.contacts().count(), 4);
  const auto data = system.create_data(double{});
  system.evaluate(built->guess.x(0).data(), built->guess.u(0).data(), *data);
  const auto& d = static_cast<const Data&>(*data);
  for (const double a : d.f) EXPECT_NEAR(a, 0, 1e-8);
  Vector3<double> sum{0, 0, 0};
  for (const auto& contact : d.contacts.contacts) sum += contact_force_in_world(contact).linear;
  EXPECT_NEAR(sum.x, 0, 1e-6);
  EXPECT_NEAR(sum.y, 0, 1e-6);
  EXPECT_NEAR(sum.z, 9.81 * system.robot().total_mass(), 1e-6);
}

/// Kinetic and potential energy of a robot in a state.
double energy(const RobotModel& robot, const double* x) {
  RobotData<double> data(robot);
  update_placements(robot, x, data);
  update_velocities(robot, x + robot.nq, data);
  update_composite_inertias(robot, data);
  return kinetic_energy(robot, data) + potential_energy(robot, data);
}

TEST(QuadrupedJump, ConservesEnergyInFlightButNotAtImpact) {
  const Solved s = solve_ready("quadruped_jump");
  ASSERT_EQ(s.result->status, SolveStatus::converged);
  const RobotModel& robot = s.built->plant.robot();
  int impulses = 0, flying = 0;
  double worst = 0;
  for (int k = 0; k < s.built->problem->knots(); ++k) {
    const KnotModel& model = *s.built->problem->knot(k).model;
    const double before = energy(robot, s.trajectory().x(k).data());
    const double after = energy(robot, s.trajectory().x(k + 1).data());
    if (model.integrator() == Integrator::impulse) {
      ++impulses;
      EXPECT_LT(after, before);
      continue;
    }
    if (s.system(k).contacts().count() > 0) continue;
    ++flying;
    // Work of the controls, with an error quadratic in the step.
    const double dt = s.built->problem->knot(k).dt;
    double work = 0;
    const Eigen::VectorXd mean = 0.5 * (s.trajectory().x(k) + s.trajectory().x(k + 1));
    for (int i = 0; i < model.nu(); ++i)
      work += dt * s.trajectory().u(k)[i] * mean[robot.nq + 6 + i];
    worst = std::max(worst, std::abs(after - before - work) / (dt * dt));
  }
  EXPECT_EQ(impulses, 1);
  EXPECT_GT(flying, 5);
  // Semi-implicit Euler gains ½ m g² dt² per step of falling.
  EXPECT_LT(worst, 5 * 0.5 * robot.total_mass() * 9.81 * 9.81);
}

}  // namespace
}  // namespace conddp
