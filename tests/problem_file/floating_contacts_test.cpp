// Contact-implicit robots with a floating base.
#include "problem_file/assemble/build_problem.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

std::string said_of(const std::vector<std::string>& settings) {
  Diagnostics out;
  auto spec = read_problem(kProblems / "crate_tumble.yaml", settings, out);
  if (spec) build_problem(*spec, {}, out);
  return format_diagnostics(out, false);
}

TEST(FloatingContacts, RejectsTheMidpointRuleByName) {
  const std::string said = said_of({"stepping.scheme=variational_midpoint"});
  EXPECT_NE(said.find("the joint 'base' floats, which the scheme 'variational_midpoint' does not "
                      "allow: 'backward_euler' does"),
            std::string::npos)
      << said;
}

TEST(FloatingContacts, AccelerationsAreNamedByTheTwist) {
  Diagnostics out;
  const auto spec = read_problem(kProblems / "crate_tumble.yaml", {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  const SteppingLayout& layout = built->plant.stepping()->layout();
  const std::vector<std::string> names = {"a/base/vx", "a/base/vy", "a/base/vz",
                                          "a/base/wx", "a/base/wy", "a/base/wz"};
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(layout.columns[layout.acceleration + i].name, names[i]);
    EXPECT_EQ(layout.columns[layout.acceleration + i].unit, i < 3 ? "m/s²" : "rad/s²");
  }
}

/// The guess that holds a crate at rest on the ground: its corners share the load equally.
TEST(FloatingContacts, RestingCrateIsCarriedByItsLowerCorners) {
  Diagnostics out;
  const auto spec =
      read_problem(kProblems / "crate_tumble.yaml", {"initial_guess.states=initial"}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  const SteppingLayout& layout = built->plant.stepping()->layout();
  const auto w = built->guess.u(5);
  double sum = w[2];  // the hand along z
  for (int c = 0; c < 8; ++c) {
    const double force = w[layout.candidates[c].force];
    sum += force;
    // The upper corners, 0.2 m above the ground, carry the force that the initial relaxation allows
    // a pair.
    const double loose = spec->solver.options.complementarity.initial / 0.2;
    EXPECT_NEAR(force, c < 4 ? w[layout.candidates[0].force] : loose, 1e-6) << c;
  }
  EXPECT_NEAR(sum, 9.81, 1e-6);
}

}  // namespace
}  // namespace conddp
