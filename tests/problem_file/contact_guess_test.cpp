// Guesses of controls and contact forces for contact-implicit steps.
#include <cmath>

#include "ocp/residuals/stepping_residual.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

const std::string kHeld = "initial_guess.controls=quasi_static";

/// An example problem whose guess holds its states.
struct Held {
  explicit Held(const std::string& name, std::vector<std::string> settings = {}) {
    Diagnostics out;
    settings.push_back(kHeld);
    spec = read_problem(kProblems / (name + ".yaml"), settings, out);
    if (spec) built = build_problem(*spec, {}, out);
    EXPECT_TRUE(built) << format_diagnostics(out, false);
  }
  const SteppingSystem& system() const { return *built->plant.stepping(); }
  const SteppingLayout& layout() const { return system().layout(); }
  int first() const { return built->problem->phases().front().instant ? 1 : 0; }
  auto w(int k) const { return built->guess.u(k); }

  /// Residual of the equations of motion in a step.
  Eigen::VectorXd left(int k) const {
    const auto equations = stepping_residual(built->plant.stepping(), built->problem->ndx());
    const auto data = system().create_data(double{});
    const double h = built->problem->knot(k).dt;
    std::vector<double> rows(equations->size());
    equations->evaluate({built->guess.x(k).data(), w(k).data(), &h, *data}, rows.data());
    return Eigen::Map<const Eigen::VectorXd>(rows.data(), system().nv());
  }

  std::optional<ProblemSpec> spec;
  std::optional<BuiltProblem> built;
};

/// Forces keep a hundredth of a newton off their bounds, which may produce that force times a lever
/// arm.
constexpr double kOffBounds = 0.05;

TEST(ContactGuess, ForcesCarryTheWeightOnASlope) {
  const Held block("block_slope");
  const auto w = block.w(10);
  double normal = 0, along = 0;
  for (const auto& c : block.layout().candidates) {
    normal += w[c.force];
    along += w[c.friction.force[0]] - w[c.friction.force[1]];
    EXPECT_LE(w[c.friction.force[0]] + w[c.friction.force[1]], 0.5 * w[c.force] + 1e-9);
  }
  EXPECT_NEAR(normal, 9.81 * std::cos(0.3), kOffBounds);
  EXPECT_NEAR(w[0] + along, -9.81 * std::sin(0.3), kOffBounds);  // force and friction
  EXPECT_LT(block.left(10).lpNorm<Eigen::Infinity>(), kOffBounds);
  EXPECT_EQ(block.built->guess_used.controls,
            "those that hold the guessed states together with contact forces");
}

TEST(ContactGuess, DistantContactsCarryNothing) {
  const Held block("block_slope", {"initial_state.joints.base_z=1.5"});
  const double most = block.spec->solver.options.complementarity.initial;
  for (const auto& c : block.layout().candidates)
    EXPECT_LE(block.w(3)[c.force] * block.w(3)[c.gap], most * (1 + 1e-9));
  EXPECT_GT(block.left(3).lpNorm<Eigen::Infinity>(), 9);
  EXPECT_NE(block.built->guess_used.controls.find("as far as they can: 50 of 50 steps"),
            std::string::npos)
      << block.built->guess_used.controls;
}

TEST(ContactGuess, QuadrupedStandsByItsTorques) {
  const Held robot("planar_quadruped_gait");
  for (int k = robot.first(); k < robot.built->guess.knots(); ++k) {
    EXPECT_LT(robot.left(k).lpNorm<Eigen::Infinity>(), kOffBounds) << k;
    const KnotModel& model = *robot.built->problem->knot(k).model;
    for (int i = 0; i < robot.layout().actuators; ++i) {
      EXPECT_GE(robot.w(k)[i], model.control_lower()[i]);
      EXPECT_LE(robot.w(k)[i], model.control_upper()[i]);
    }
  }
}

TEST(ContactGuess, TorquesRespectTheirLimits) {
  const Held robot("planar_quadruped_gait",
                   {"constraints.torque={bounds: control, lower: -1, upper: 1}"});
  double largest = 0;
  for (int i = 0; i < robot.layout().actuators; ++i)
    largest = std::max(largest, std::abs(robot.w(5)[i]));
  EXPECT_EQ(largest, 1);
  EXPECT_GT(robot.left(5).lpNorm<Eigen::Infinity>(), kOffBounds);
}

TEST(ContactGuess, ConeHoldsByItsUsedFrictionShare) {
  const Held puck(
      "puck_slide",
      {"robot.placement.rpy=[0, 0.1, 0]",
       "contact_candidates.front.against.half_space.normal=[0.09983341664, 0, 0.99500416527]",
       "contact_candidates.left.against.half_space.normal=[0.09983341664, 0, 0.99500416527]",
       "contact_candidates.right.against.half_space.normal=[0.09983341664, 0, 0.99500416527]"});
  const auto w = puck.w(20);  // forces on the puck must vanish
  double normal = 0;
  for (const auto& c : puck.layout().candidates) {
    normal += w[c.force];
    for (int i = 0; i < 2; ++i)
      EXPECT_NEAR(w[c.cone.force[i]], -0.3 * w[c.force] * w[c.cone.use[i]], 1e-12);
  }
  EXPECT_NEAR(normal, 0.5 * 9.81 * std::cos(0.1), kOffBounds);
  EXPECT_LT(puck.left(20).lpNorm<Eigen::Infinity>(), kOffBounds);
}

class HeldGuessOf : public ::testing::TestWithParam<const char*> {};

TEST_P(HeldGuessOf, IsFiniteAndInside) {
  const Held ready(GetParam());
  const auto& guess = ready.built->guess;
  for (int k = ready.first(); k < guess.knots(); ++k) {
    EXPECT_TRUE(guess.u(k).allFinite()) << k;
    for (const auto& [z, s] : ready.layout().pairs) {
      EXPECT_GE(guess.u(k)[z], 0.01) << k;
      EXPECT_GE(guess.u(k)[s], 0.01) << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Ready, HeldGuessOf,
                         ::testing::Values("acrobot_limits", "block_drag", "block_slope",
                                           "cartpole_friction", "cartpole_walls", "finger_spinner",
                                           "footed_hopper", "planar_biped_gait",
                                           "planar_quadruped_gait", "puck_slide", "push_box",
                                           "push_obstacle", "raibert_gait"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace conddp
