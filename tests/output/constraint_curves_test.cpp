#include "output/report/constraint_curves.hpp"

#include <cmath>
#include <limits>

#include "output/solution/contact_forces.hpp"
#include "report_fixture.hpp"

namespace conddp {
namespace {

TEST_F(Report, DrawsConstraintsWithBoundsAndViolation) {
  load("unicycle_obstacles.yaml");
  Trajectory& trajectory = result_->trajectory;
  trajectory.x(7) << 1.0, 0.75, 0.1;  // in the disc at (0.75, 0.75)
  trajectory.x(8) << 0.75, 1.75, 0.1;
  trajectory.x(100) << 3, 3.5, 0.25;
  const OrderedJson list = constraint_curves(*built_, trajectory);
  const OrderedJson& disc = named(list, "disc_1");
  const int first = disc["first"];
  EXPECT_EQ(first, 1);
  EXPECT_EQ(disc["violation"].size(), 99u);
  EXPECT_EQ(disc["margin"], false);
  ASSERT_EQ(disc["rows"].size(), 1u);
  EXPECT_EQ(disc["rows"][0]["lower"], 0.425);
  EXPECT_TRUE(disc["rows"][0]["upper"].is_null());
  EXPECT_NEAR(disc["rows"][0]["values"][7 - first].get<double>(), 0.25, 1e-8);
  EXPECT_NEAR(disc["violation"][7 - first].get<double>(), 0.175, 1e-8);
  EXPECT_NEAR(disc["rows"][0]["values"][8 - first].get<double>(), 1, 1e-8);
  EXPECT_EQ(disc["violation"][8 - first], 0);
  const OrderedJson& goal = named(list, "terminal/goal");
  EXPECT_EQ(goal["first"], 100);
  ASSERT_EQ(goal["rows"].size(), 3u);
  EXPECT_EQ(goal["rows"][1]["name"], "y");
  EXPECT_NEAR(goal["rows"][1]["values"][0].get<double>(), 0.5, 1e-8);
  EXPECT_NEAR(goal["violation"][0].get<double>(), 0.5, 1e-8);
}

TEST_F(Report, SharedConstraintNamesShowTheSmallestMargin) {
  load("quadruped_stand.yaml", {"constraints.cone={residual: friction_cone, cone: second_order}"});
  const OrderedJson cone = named(constraint_curves(*built_, result_->trajectory), "cone");
  EXPECT_EQ(cone["margin"], true);
  ASSERT_EQ(cone["rows"].size(), 1u);
  const ContactForces forces =
      contact_forces(*built_, NodeValues(*built_->problem, result_->trajectory));
  for (const int k : {0, 30}) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 4; ++i) {
      const auto& f = *forces.contacts[i].wrench[k];
      const ContactSpec& contact = spec_->contacts[i];
      least = std::min({least, contact.friction * f[2] - std::hypot(f[0], f[1]),
                        f[2] - contact.min_normal_force});
    }
    EXPECT_NEAR(cone["rows"][0]["values"][k].get<double>(), least, 1e-6 * std::abs(least)) << k;
  }
}

TEST_F(Report, DrawsAndMarksDroppedConstraints) {
  load("unicycle_obstacles.yaml", {}, {"disc_2"});
  const OrderedJson list = constraint_curves(*built_, result_->trajectory);
  const OrderedJson& disc = named(list, "disc_2 (left out)");
  EXPECT_EQ(disc["rows"][0]["lower"], 0.425);
  EXPECT_EQ(disc["first"].get<std::size_t>() + disc["violation"].size(), 100u);
  EXPECT_EQ(named(list, "disc_1")["violation"].size(), 99u);
  for (const OrderedJson& entry : list) EXPECT_NE(entry["name"], "disc_2");
}

TEST_F(Report, ShowsConstraintMultipliersByNameAtTheirNodes) {
  load("unicycle_obstacles.yaml");
  OrderedJson& multipliers = document_["multipliers"]["constraints"];
  for (OrderedJson& constraint : multipliers) {
    if (constraint["name"] == "disc_1" && constraint["node"] == 7) constraint["multiplier"] = {-3};
    if (constraint["name"] == "goal") constraint["multiplier"] = {1, -5, 2};
  }
  const OrderedJson curves =
      report_data({entry()})["solutions"][0]["curves"]["constraint_multipliers"];
  EXPECT_EQ(curves["disc_1"].size(), 101u);
  EXPECT_EQ(curves["disc_1"][7], 3);
  EXPECT_TRUE(curves["disc_1"][0].is_null());
  EXPECT_EQ(curves["terminal/goal"][100], 5);
}

}  // namespace
}  // namespace conddp
