#include "ocp/problem/control_columns.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/expression_systems.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// Two knots with a state moved by these controls.
Phase pushed_by(const std::vector<std::string>& controls) {
  std::string sum = "0";
  for (const std::string& control : controls) sum += " + " + control;
  const auto system = expression_system({.kind = SystemKind::first_order,
                                         .states = {{"x"}},
                                         .controls = expression_columns(controls),
                                         .equations = {{"x", sum}}});
  return {.name = controls.front(),
          .model = std::make_shared<KnotModel>(system, Integrator::explicit_euler),
          .dt = {0.1, 0.1},
          .cost_scale = {0.1, 0.1},
          .parameters = {}};
}

ShootingProblem pushed_in_turn(const std::vector<std::vector<std::string>>& turns) {
  std::vector<Phase> phases;
  for (const auto& controls : turns) phases.push_back(pushed_by(controls));
  Phase end{
      .name = "end",
      .model = std::make_shared<KnotModel>(phases.front().model->shared_system(), Integrator::none),
      .dt = {0},
      .cost_scale = {1},
      .parameters = {}};
  return {{0.0}, std::move(phases), std::move(end)};
}

TEST(ControlColumns, ListAllPhasesInOrderOfAppearance) {
  const ShootingProblem problem = pushed_in_turn({{"b", "a"}, {"c", "b"}});
  const ControlColumns columns(problem);
  ASSERT_EQ(columns.count(), 3);
  EXPECT_EQ(columns.columns()[0].name, "b");
  EXPECT_EQ(columns.columns()[1].name, "a");
  EXPECT_EQ(columns.columns()[2].name, "c");
  for (const int knot : {0, 1}) {
    EXPECT_TRUE(columns.are_some(knot));
    EXPECT_TRUE(std::ranges::equal(columns.columns_of(knot), std::vector<int>{0, 1}));
  }
  for (const int knot : {2, 3})
    EXPECT_TRUE(std::ranges::equal(columns.columns_of(knot), std::vector<int>{2, 0}));
}

TEST(ControlColumns, RowsHoldNumbersOfTheKnotOnly) {
  const ShootingProblem problem = pushed_in_turn({{"b", "a"}, {"c", "b"}});
  const ControlColumns columns(problem);
  const Eigen::VectorXd row = columns.row(2, Eigen::Vector2d(5, 7));
  EXPECT_EQ(row[0], 7);
  EXPECT_TRUE(std::isnan(row[1]));
  EXPECT_EQ(row[2], 5);
  EXPECT_EQ(columns.own(2, row), Eigen::Vector2d(5, 7));
  // A row of another length already belongs to the knot.
  EXPECT_EQ(columns.own(2, Eigen::Vector2d(1, 2)), Eigen::Vector2d(1, 2));
  EXPECT_EQ(columns.own_entries(2, Json{7, nullptr, 5}), (Json{5, 7}));
  EXPECT_EQ(columns.own_entries(2, Json{1, 2}), (Json{1, 2}));
  EXPECT_EQ(columns.own_entries(2, Json("none")), Json("none"));
  EXPECT_EQ(columns.own_entries(2, Json{{"b", 1}, {"a", 2}, {"c", 3}}),
            (Json{{"b", 1}, {"a", 2}, {"c", 3}}));
}

TEST(ControlColumns, SingleControlSetMatchesTheKnot) {
  const ShootingProblem problem = pushed_in_turn({{"a", "b"}, {"a", "b"}});
  const ControlColumns columns(problem);
  EXPECT_EQ(columns.count(), 2);
  for (int knot = 0; knot < 4; ++knot) {
    EXPECT_FALSE(columns.are_some(knot));
    EXPECT_EQ(columns.row(knot, Eigen::Vector2d(1, 2)), Eigen::Vector2d(1, 2));
    EXPECT_EQ(columns.own_entries(knot, Json{1, 2}), (Json{1, 2}));
  }
}

}  // namespace
}  // namespace conddp
