#include "output/scene/found_contacts.hpp"

#include "problem_file/assemble/build_problem.hpp"
#include "report_fixture.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// A block with a sphere at a corner, above the ground and in front of a slope.
constexpr const char* kBlockAndSlope = R"(conddp: 1
name: block_and_slope
robot: {urdf: robots/block.urdf, actuation: {joints: [base_x]}}
initial_state: {joints: {base_z: 0.5}}
contact_candidates:
  ground: {frame: corner_1, radius: 0.05, friction: 0.5}
  slope: {frame: corner_1, radius: 0.05, friction: 0.5,
          against: {half_space: {normal: [-0.6, 0, 0.8], point: [0, 0, -1]}}}
stepping: {plane: [0, 1, 0]}
phases: [{name: push, knots: 3, dt: 0.05}]
costs: {effort: {residual: control}}
solver: {name: ipopt}
)";

TEST(FoundContacts, ForcesAreInTheWorldAtStepEnds) {
  Diagnostics out;
  const auto file = source_tree() / "problems/text.yaml";
  const auto spec = read_problem_text(kBlockAndSlope, file, {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  Trajectory trajectory = built->problem->create_trajectory();
  for (int k = 0; k <= 3; ++k) {
    trajectory.x(k).setZero();
    trajectory.x(k)[0] = 0.1 * k;  // forward motion with rotation
    trajectory.x(k)[2] = 0.2 * k;
    if (k < 3) trajectory.u(k).setZero();
  }
  const auto control = [&](int k, const std::string& name) -> double& {
    for (std::size_t i = 0; i < built->control_columns.size(); ++i)
      if (built->control_columns[i].name == name) return trajectory.u(k)[i];
    throw std::out_of_range(name);
  };
  control(1, "contact/ground/fn") = 7;
  control(1, "contact/ground/ft-") = 2;
  control(1, "contact/slope/fn") = 10;
  control(1, "contact/slope/ft+") = 5;
  control(2, "contact/ground/fn") = 1e-9;  // a barrier residue

  const auto motion = contact_motion(*built->problem, trajectory);
  ASSERT_TRUE(motion);
  const FoundContacts found = found_contacts(*motion);
  // The tangent is plane × normal: x on the ground, (0.8, 0, 0.6) on the slope.
  EXPECT_EQ(found.forces["ground"], OrderedJson::parse("[null, [-2.0, 0.0, 7.0], null]"));
  ASSERT_EQ(found.forces["slope"].size(), 3u);
  ASSERT_EQ(found.forces["slope"][1].size(), 3u);
  const double on_slope[] = {-0.6 * 10 + 0.8 * 5, 0, 0.8 * 10 + 0.6 * 5};
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(found.forces["slope"][1][i].get<double>(), on_slope[i], 1e-7) << i;

  const MultibodySystem& system = *built->plant.multibody();
  const double normals[2][3] = {{0, 0, 1}, {-0.6, 0, 0.8}};
  for (int c = 0; c < 2; ++c) {
    const OrderedJson& contact = found.contacts[c];
    EXPECT_EQ(contact["acts_after"], 1);
    EXPECT_EQ(contact["ground"], true);
    for (int k = 0; k <= 3; ++k) {
      const std::vector<double> x(trajectory.x(k).begin(), trajectory.x(k).end());
      const Vector3<double> corner =
          placement_in_state(system, x, *system.robot().find_frame("corner_1")).p;
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(contact["normals"][3 * k + i].get<double>(), normals[c][i], 1e-6);
        EXPECT_NEAR(contact["positions"][3 * k + i].get<double>(), corner[i] - 0.05 * normals[c][i],
                    2e-6)
            << c << ' ' << k << ' ' << i;
      }
    }
  }
}

TEST_F(Report, ShowsFoundContactsLikeScheduledOnes) {
  load("block_slope.yaml");
  const OrderedJson shown = report_data({entry()})["solutions"][0];
  ASSERT_FALSE(spec_->candidates.empty());
  EXPECT_EQ(shown["scene"]["contacts"].size(), spec_->candidates.size());
  for (const CandidateSpec& candidate : spec_->candidates) {
    const std::string& name = candidate.name.value;
    EXPECT_EQ(shown["curves"]["contact_forces"].at(name).size(),
              static_cast<std::size_t>(built_->problem->knots()));
    EXPECT_NO_THROW(named(shown["scene"]["contacts"], name));
  }
}

}  // namespace
}  // namespace conddp
