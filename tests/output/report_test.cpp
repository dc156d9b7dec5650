#include "base/json/json_document.hpp"
#include "output/scene/motion_scene.hpp"
#include "report_fixture.hpp"

namespace conddp {
namespace {

SE3<double> read_placement(const OrderedJson& list, std::size_t at) {
  const auto number = [&](std::size_t i) { return list[at + i].get<double>(); };
  return {rotation_matrix(Quaternion<double>{number(3), number(4), number(5), number(6)}),
          {number(0), number(1), number(2)}};
}

TEST_F(Report, BodiesCarryContactFramesToTheirPlaces) {
  load("quadruped_trot.yaml");
  const OrderedJson scene = motion_scene(*built_, result_->trajectory);
  const MultibodySystem& system = *built_->plant.multibody();
  const std::size_t bodies = scene["bodies"].size();
  ASSERT_EQ(bodies, system.robot().joints.size() + 1);
  ASSERT_EQ(scene["contacts"].size(), 4u);
  for (const int k : {0, 17, 64}) {
    const std::vector<double> x(result_->trajectory.x(k).begin(), result_->trajectory.x(k).end());
    for (const OrderedJson& contact : scene["contacts"]) {
      const std::string frame = spec_->contacts[&contact - &scene["contacts"][0]].frame.value;
      const SE3<double> expected = placement_in_state(system, x, *system.robot().find_frame(frame));
      const SE3<double> found =
          read_placement(scene["poses"], 7 * (bodies * k + contact["body"].get<std::size_t>())) *
          read_placement(contact["placement"], 0);
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(found.p[i], expected.p[i], 5e-6) << frame << ' ' << k;
        EXPECT_NEAR(contact["positions"][3 * k + i].get<double>(), expected.p[i], 1e-6) << frame;
      }
    }
  }
}

TEST_F(Report, ShowsEveryMovingBodyOfExampleRobots) {
  for (const char* name : {"quadruped_stand.yaml", "biped_squat.yaml", "hopper_jump.yaml",
                           "arm_reach.yaml", "body_reorient.yaml"}) {
    load(name);
    const OrderedJson scene = motion_scene(*built_, result_->trajectory);
    int shapes = 0;
    for (const OrderedJson& body : scene["bodies"])
      shapes += static_cast<int>(body["shapes"].size());
    EXPECT_GE(shapes, 1) << name;
    for (int i = 0; i < built_->plant.robot().joint_count(); ++i) {
      const bool has_mass = built_->plant.robot().joints[i].inertia.mass > 0;
      EXPECT_TRUE(!has_mass || !scene["bodies"][i + 1]["shapes"].empty()) << name << ' ' << i;
    }
  }
}

TEST_F(Report, PlacesClosedFormSystemsByTheirStates) {
  load("cartpole_swingup_closed_form.yaml");
  Trajectory& trajectory = result_->trajectory;
  trajectory.x(3) << 0.7, M_PI / 2, 0, 0;
  const OrderedJson scene = motion_scene(*built_, trajectory);
  ASSERT_EQ(scene["bodies"].size(), 3u);
  const SE3<double> cart = read_placement(scene["poses"], 7 * (3 * 3 + 1));
  EXPECT_NEAR(cart.p.x, 0.7, 1e-12);
  // The pole hangs at zero; at π/2 it points forward.
  const OrderedJson& bob = scene["bodies"][2]["shapes"][1];
  const SE3<double> tip =
      read_placement(scene["poses"], 7 * (3 * 3 + 2)) * read_placement(bob["placement"], 0);
  EXPECT_NEAR(tip.p.x, 0.7 + 0.5, 1e-12);
  EXPECT_NEAR(tip.p.z, 0, 1e-12);
}

TEST_F(Report, CostsOverTheNodesSumToTheCost) {
  load("quadruped_jump.yaml");
  const OrderedJson data = report_data({entry()});
  double sum = 0;
  for (const OrderedJson& values : data["solutions"][0]["curves"]["costs"])
    for (const OrderedJson& value : values) sum += value.get<double>();
  EXPECT_NEAR(sum, result_->cost, 1e-6 * result_->cost);
}

TEST_F(Report, SolutionWithoutItsProblemStillHasCurves) {
  load("cartpole_swingup.yaml");
  ReportEntry alone = entry();
  alone.built = nullptr;
  const OrderedJson data = report_data({alone, entry()});
  EXPECT_TRUE(data["solutions"][0]["scene"].is_null());
  EXPECT_FALSE(data["solutions"][1]["scene"].is_null());
  EXPECT_EQ(data["solutions"][0]["curves"]["x"]["values"],
            data["solutions"][1]["curves"]["x"]["values"]);
}

TEST_F(Report, RejectsSolutionsOfAnotherShape) {
  load("cartpole_swingup.yaml");
  document_["trajectory"]["x"].erase(0);
  EXPECT_THROW(report_data({entry()}), MalformedSolution);
  EXPECT_THROW(check_report_document(document_), MalformedSolution);
}

TEST(ReportPage, TextCannotLeaveItsElement) {
  const std::string page = std::string("<p>") + kReportPlaceholder + "</p>";
  const OrderedJson data = {{"name", "</script><b>&\xf0\x9f\x98\x80\xff"}};
  const std::string made = report_page(page, data);
  const std::string inside = made.substr(3, made.size() - 7);
  EXPECT_EQ(inside.find_first_of("<>&"), std::string::npos) << inside;
  EXPECT_TRUE(std::all_of(inside.begin(), inside.end(), [](char c) { return c > 0; }));
  EXPECT_TRUE(
      OrderedJson::parse(inside)["name"].get<std::string>().starts_with("</script><b>&\xf0\x9f"));
  EXPECT_THROW(report_page("no place", data), std::logic_error);
}

}  // namespace
}  // namespace conddp
