// SRDF files: group states as configurations, and disabled pairs.
#include "problem_text.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// A problem of a robot with this content of its SRDF file.
struct WithSrdf {
  WithSrdf(const std::string& srdf, const std::string& robot, const std::string& rest,
           const std::string& urdf = "arm7") {
    folder.write("arm.srdf", srdf);
    text = "conddp: 1\nrobot: {urdf: '" + (kProblems / "robots" / urdf).string() + ".urdf" +
           "', srdf: '" + (folder / "arm.srdf").string() + "'" + robot + "}\n" + rest +
           "phases: [{knots: 3, dt: 0.02}]\n";
  }
  TemporaryFolder folder;
  std::string text;
};

const std::string kStates = R"(<robot name="arm">
<group_state name="home" group="upper"><joint name="joint_2" value="0.5"/>
  <joint name="nothing" value="3"/></group_state>
<group_state name="home" group="lower"><joint name="joint_4" value=" -1 "/></group_state>
<group_state name="own" group="lower"><joint name="joint_4" value="-2"/></group_state>
<group_state name="there" group="all"><joint name="root_joint" value="1 2 3 0 0 1 0"/></group_state>
</robot>)";

TEST(Srdf, GroupStatesAreConfigurations) {
  const WithSrdf file(kStates, ", configurations: {own: {joints: {joint_4: -0.3}}}",
                      "initial_state: {configuration: home}\n"
                      "costs: {own: {residual: state, reference: own}}\n");
  const Loaded loaded(file.text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double>& x = loaded.built->problem->initial_state();
  EXPECT_EQ(std::vector(x.begin(), x.begin() + 7), (std::vector<double>{0, 0.5, 0, -1, 0, 0, 0}));
  EXPECT_EQ(loaded.built->plant.parts.front().spec->configurations.size(), 3u);
}

TEST(Srdf, SevenValuesPlaceAFloatingBase) {
  const WithSrdf file(
      kStates, ", base: floating",
      "initial_state: {configuration: there}\ncosts: {effort: {residual: control}}\n", "quadruped");
  const Loaded loaded(file.text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double>& x = loaded.built->problem->initial_state();
  EXPECT_EQ(std::vector(x.begin(), x.begin() + 7), (std::vector<double>{1, 2, 3, 0, 0, 1, 0}));
}

TEST(Srdf, JointsWithoutACoordinateAreLeftOut) {
  const WithSrdf file(
      kStates, ", locked_joints: {joint_2: 0}",
      "initial_state: {configuration: home}\ncosts: {effort: {residual: control}}\n");
  const Loaded loaded(file.text);
  ASSERT_TRUE(loaded.built) << loaded.all();
}

TEST(Srdf, DisabledPairsAreNoSelfCollisions) {
  const std::string pairs =
      "collision: {from: urdf}\ncosts: {clear: {residual: distance, pairs: self}}\n"
      "initial_state: {joints: {joint_4: -1}}\n";
  const auto rows = [&](const std::string& disabled) {
    const WithSrdf file("<robot name=\"arm\">" + disabled + "</robot>", "", pairs);
    const Loaded loaded(file.text);
    EXPECT_TRUE(loaded.built) << loaded.all();
    return loaded.built ? loaded.built->problem->knot(0).model->costs()[0].residual->size() : 0;
  };
  const int all = rows("");
  EXPECT_GT(all, 1);
  EXPECT_EQ(rows("<disable_collisions link1=\"link_5\" link2=\"link_3\"/>"), all - 1);
}

TEST(Srdf, BadFilesAreErrors) {
  const std::string rest = "initial_state: {}\ncosts: {effort: {residual: control}}\n";
  const WithSrdf broken("<robot name=\"arm\"><group", "", rest), other("<sdf/>", "", rest);
  EXPECT_NE(Loaded(broken.text).first_error().find("is no SRDF file"), std::string::npos);
  EXPECT_NE(Loaded(other.text).first_error().find("it has no <robot>"), std::string::npos);
  const Loaded absent("conddp: 1\nrobot: {urdf: robots/arm7.urdf, srdf: none.srdf}\n" + rest +
                      "phases: [{knots: 3, dt: 0.02}]\n");
  EXPECT_EQ(absent.first_error().find("2:39: 'none.srdf'"), 0u) << absent.first_error();
}

}  // namespace
}  // namespace conddp
