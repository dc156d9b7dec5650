#include "analysis/contact/contact_pairs.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

Eigen::RowVectorXd row(std::initializer_list<double> numbers) {
  Eigen::RowVectorXd values(numbers.size());
  std::copy(numbers.begin(), numbers.end(), values.data());
  return values;
}

/// A contact with a normal and two tangents in three velocities; the first velocity is normal.
ContactPairs contact(const Eigen::VectorXd& v, double friction) {
  ContactPairs pairs(6, 3);
  const int normal = pairs.add(0.25, row({1, 0, 0}), row({1, 0, 0}));
  Eigen::MatrixXd tangents(2, 3);
  tangents << 0, 1, 0, 0, 0, 1;
  pairs.add_friction(tangents, 2 * tangents, v, {.factor = friction, .normal = normal});
  return pairs;
}

TEST(ContactPairs, FrictionHasSignedTangentsAndSpeedSlack) {
  const ContactPairs pairs = contact(Eigen::Vector3d(5, 0.5, -0.25), 0.8);
  EXPECT_EQ(pairs.value, (Eigen::VectorXd(6) << 0.25, 0.5, -0.5, -0.25, 0.25, 0).finished());
  EXPECT_EQ(pairs.push.row(2), row({0, -1, 0}));
  EXPECT_EQ(pairs.slope.row(2), row({0, -2, 0}));
  EXPECT_EQ(pairs.budget, std::vector<bool>({false, false, false, false, false, true}));
}

TEST(ContactPairs, FrictionStaysWithinNormalImpulseBudget) {
  const ContactPairs pairs = contact(Eigen::Vector3d::Zero(), 0.8);
  // z: normal impulse 2, friction impulses 0.5 and 0.25 along the edges.
  const Eigen::VectorXd z = (Eigen::VectorXd(6) << 2, 0.5, 0, 0, 0.25, 3).finished();
  const Eigen::VectorXd w = pairs.value + pairs.coupling * z;
  EXPECT_DOUBLE_EQ(w[5], 0.8 * 2 - 0.75);
  // The speed slack appears in each edge.
  for (int edge = 1; edge < 5; ++edge) EXPECT_DOUBLE_EQ(w[edge], 3);
  EXPECT_DOUBLE_EQ(w[0], 0.25);
}

TEST(ContactPairs, ConstantBudgetNeedsNoNormal) {
  ContactPairs pairs(3, 1);
  pairs.add_friction(row({1}), row({1}), Eigen::VectorXd::Ones(1), {.constant = 0.5});
  EXPECT_DOUBLE_EQ(pairs.value[2], 0.5);
  EXPECT_TRUE(pairs.coupling.row(2).isApprox(row({-1, -1, 0})));
}

TEST(ContactPairs, SlowestEdgeHasTheLeastSpeed) {
  const ContactPairs pairs = contact(Eigen::Vector3d(0, 0.5, -0.75), 0.8);
  EXPECT_EQ(pairs.slowest_edge(5, pairs.value), 3);
  EXPECT_EQ(pairs.slowest_edge(0, pairs.value), std::nullopt);
}

TEST(ContactPairs, AtRestHaveNoEffect) {
  ContactPairs pairs(3, 1);
  pairs.rest(2);
  EXPECT_EQ(pairs.add(4, row({1}), row({1})), 2);
  EXPECT_EQ(pairs.value, Eigen::Vector3d(1, 1, 4));
  EXPECT_TRUE(pairs.push.topRows(2).isZero(0));
  EXPECT_TRUE(pairs.coupling.isZero(0));
}

}  // namespace
}  // namespace conddp
