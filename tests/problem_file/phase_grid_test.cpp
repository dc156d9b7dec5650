// Grids refined at the start or end of phases, and kp targets of stepping feet.
#include "problem_file/model/phase_grid.hpp"

#include "problem_text.hpp"

namespace conddp {
namespace {

void expect_times(const Loaded& loaded, const std::vector<double>& expected) {
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double>& times = loaded.built->problem->times();
  ASSERT_EQ(times.size(), expected.size());
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], expected[i], 1e-12) << i;
}

TEST(RefinedPhase, HasStepsThatShortenTowardsItsEnds) {
  const Loaded loaded(replaced(kPendulum, "dt: 0.1", "dt: 0.1, refine: {first: 2, last: 1}"));
  expect_times(loaded, {0, 0.025, 0.075, 0.175, 0.225, 0.275, 0.325, 0.375, 0.425, 0.475, 0.525});
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_DOUBLE_EQ(problem.knot(0).dt, 0.025);
  EXPECT_DOUBLE_EQ(problem.knot(0).cost_scale, 0.025) << "a rate is multiplied by its own step";
}

TEST(RefinedPhase, KeepsItsDuration) {
  const Loaded loaded(
      replaced(kPendulum, "dt: 0.1", "duration: 1.3, refine: {first: 3, ratio: 0.1}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const double dt = 1.3 / 1.111;
  EXPECT_NEAR(loaded.spec->phases[0].dt, dt, 1e-12);
  EXPECT_NEAR(loaded.built->problem->times()[1], 0.001 * dt, 1e-12);
  EXPECT_NEAR(loaded.built->problem->times()[4], 1.3, 1e-12);
}

TEST(RefinedPhase, RejectsImpossibleGridsWithPlaces) {
  const auto error = [](const char* refine) {
    return Loaded(replaced(kPendulum, "dt: 0.1", std::string("dt: 0.1, refine: ") + refine))
        .first_error();
  };
  EXPECT_EQ(error("{first: 2, last: 2}"),
            "7:46: 'first' and 'last' leave none of the 4 knots as it is");
  EXPECT_EQ(error("{ratio: 0.5}"), "7:46: nothing is refined");
  EXPECT_NE(error("{first: 1, ratio: 1}").find("a number between 0 and 1"), std::string::npos);
  EXPECT_NE(error("{first: 3, ratio: 1.0e-9}").find("are lost to rounding at the time"),
            std::string::npos)
      << error("{first: 3, ratio: 1.0e-9}");
  const Loaded car(R"(conddp: 1
system: {type: car}
initial_state: {}
phases: [{knots: 3, dt: 0.1, refine: {first: 1}}]
)");
  EXPECT_NE(car.first_error().find("the steps of this system must have the same length"),
            std::string::npos)
      << car.all();
}

constexpr std::string_view kSteps = R"(conddp: 1
robot: {urdf: robots/quadruped.urdf, base: floating}
contacts:
  defaults: {baumgarte: {kp: 100, kd: 20}}
  LF: {frame: lf_foot}
  RF: {frame: rf_foot}
initial_state: {base: {position: [0, 0, 0.57]}}
phases:
  - {name: stand, knots: 2, dt: 0.1, contacts: all}
  - {name: lift, knots: 3, dt: 0.1, contacts: RF}
  - {name: land, knots: 3, dt: 0.05, contacts: RF}
  - {name: between, knots: 2, dt: 0.1, contacts: all}
  - {name: again, knots: 2, dt: 0.1, contacts: RF}
  - {name: end, knots: 2, dt: 0.1, contacts: all}
costs:
  first: {residual: frame_position, frame: lf_foot, phases: [lift, land], swing: {height: 0.1, step: [0.2, 0, 0]}}
  second: {residual: frame_position, frame: lf_foot, phases: again, swing: {height: 0.1, step: [0, 0.1, 0]}}
)";

/// Target of kp for the contact LF in a phase.
Vector3<double> drawn_to(const Loaded& loaded, int phase) {
  const auto& system =
      static_cast<const MultibodySystem&>(loaded.built->problem->phases()[phase].model->system());
  return system.contacts().contacts()[0].reference.p;
}

void expect_point(const Vector3<double>& a, const Vector3<double>& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-12);
}

TEST(Stabilisation, DrawsSteppingFeetToTheirLandingPlaces) {
  const Loaded loaded{std::string(kSteps)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Vector3<double> start = drawn_to(loaded, 0);
  const int foot = *loaded.built->plant.robot().find_frame("lf_foot");
  expect_point(start, placement_in_state(*loaded.built->plant.multibody(),
                                         loaded.built->problem->initial_state(), foot)
                          .p);
  expect_point(drawn_to(loaded, 3), start + Vector3<double>{0.2, 0, 0});
  expect_point(drawn_to(loaded, 5), start + Vector3<double>{0.2, 0.1, 0});
  const Loaded fixed(replaced(kSteps, "LF: {frame: lf_foot}",
                              "LF: {frame: lf_foot, placement: {position: [1, 2, 3]}}"));
  ASSERT_TRUE(fixed.built) << fixed.all();
  for (const int phase : {0, 3, 5}) expect_point(drawn_to(fixed, phase), {1, 2, 3});
}

TEST(Stabilisation, WarnsAboutStepsWithoutASwing) {
  const Loaded loaded(
      replaced(replaced(kSteps, "swing: {height: 0.1, step: [0.2, 0, 0]}", "reference: [0, 0, 0]"),
               "swing: {height: 0.1, step: [0, 0.1, 0]}", "reference: [0, 0, 0]"));
  ASSERT_TRUE(loaded.spec) << loaded.all();
  EXPECT_NE(
      loaded.all().find("kp draws the contact 'LF' to where it is in the initial state, and in "
                        "phase 'between' it touches down anew"),
      std::string::npos)
      << loaded.all();
  const Loaded planned{std::string(kSteps)};
  EXPECT_EQ(planned.all().find("touches down anew"), std::string::npos);
}

/// Reference of a cost at a knot.
std::vector<double> reference(const Loaded& loaded, const char* cost, int knot) {
  const KnotView& view = loaded.built->problem->knot(knot);
  for (const CostTerm& term : view.model->costs())
    if (term.name == cost)
      return {view.parameters + term.parameters,
              view.parameters + term.parameters + term.residual->parameter_count()};
  return {};
}

TEST(Swing, FollowsTimeFromThePreviousLanding) {
  const Loaded loaded{std::string(kSteps)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Vector3<double> start = drawn_to(loaded, 0);
  // After 0.3 s of 0.45 s: two thirds of the time, at the fourth of six knots.
  const double s = 2.0 / 3, along = s * s * (3 - 2 * s);
  const std::vector<double> at = reference(loaded, "first", 5);
  ASSERT_EQ(at.size(), 3u);
  EXPECT_NEAR(at[0], start.x + 0.2 * along, 1e-12);
  EXPECT_NEAR(at[2], start.z + 16 * 0.1 * s * s * (1 - s) * (1 - s), 1e-12);
  const std::vector<double> second = reference(loaded, "second", 10);
  ASSERT_EQ(second.size(), 3u);
  EXPECT_NEAR(second[0], start.x + 0.2, 1e-12);
  EXPECT_NEAR(second[1], start.y, 1e-12);
}

}  // namespace
}  // namespace conddp
