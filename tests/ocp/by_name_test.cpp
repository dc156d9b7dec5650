// Costs and violations by name for a scalar x⁺ = x + u, by hand.
#include "ocp/problem/by_name.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "ocp/residuals/residuals.hpp"
#include "support/expression_systems.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

/// Two knots and the terminal node. Costs: ½ u² and, with weight 3, ½ (x − 1)². The constraint
/// "box" keeps x in [−1, 1]; "soft" limits x to 0 at a cost of 2 per unit. Both also hold at the
/// end.
ShootingProblem two_knots() {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const auto system = linear_system(one, one, Eigen::VectorXd::Zero(1));
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  running->add_cost("effort", control_residual(1, 1), {});
  const auto add_rest = [](KnotModel& model) {
    model.add_cost("place", state_residual(model.manifold()), {});
    model.add_constraint(
        make_constraint("box", state_residual(model.manifold()), ConstraintKind::bounds));
    model.add_constraint(make_constraint("soft", state_residual(model.manifold()),
                                         ConstraintKind::bounds, 1, Softness::l1));
  };
  add_rest(*running);
  add_rest(*end);
  const double below = -std::numeric_limits<double>::infinity();
  // Reference and weight of each cost; reference, bounds, switch, and weight of each constraint.
  const std::vector<double> knot = {0, 1, 1, 3, 0, -1, 1, 1, 0, below, 0, 1, 2};
  std::vector<double> twice = knot;
  twice.insert(twice.end(), knot.begin(), knot.end());
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "go", .model = running, .dt = {1, 1}, .cost_scale = {1, 2}, .parameters = twice});
  return ShootingProblem({0}, std::move(phases),
                         {.name = "end",
                          .model = end,
                          .dt = {0},
                          .cost_scale = {1},
                          .parameters = {knot.begin() + 2, knot.end()}});
}

Trajectory walk(const ShootingProblem& problem) {
  Trajectory t = problem.create_trajectory();
  t.u(0) << 2;
  t.u(1) << -1;
  t.x(1) << 2;
  t.x(2) << 3;
  return t;
}

using Costs = std::vector<std::pair<std::string, std::vector<double>>>;

TEST(CostsByNode, ListEachTermAtEachNode) {
  const ShootingProblem problem = two_knots();
  const Costs found = costs_by_node(problem, NodeValues(problem, walk(problem)));
  const Costs expected = {{"effort", {2, 2 * 0.5, 0}},
                          {"place", {1.5, 2 * 1.5, 0}},
                          {"soft", {0, 2 * 2 * 2, 0}},
                          {"terminal/place", {0, 0, 6}},
                          {"terminal/soft", {0, 0, 6}}};
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].first, expected[i].first);
    ASSERT_EQ(found[i].second.size(), 3u);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(found[i].second[k], expected[i].second[k], 1e-14) << found[i].first << ' ' << k;
  }
}

TEST(CostByName, IsTheSumOverTheNodes) {
  const ShootingProblem problem = two_knots();
  const auto found = cost_by_name(problem, NodeValues(problem, walk(problem)));
  ASSERT_EQ(found.size(), 5u);
  EXPECT_EQ(found[1].first, "place");
  EXPECT_NEAR(found[1].second, 4.5, 1e-14);
  EXPECT_NEAR(found[2].second, 8, 1e-14);
}

TEST(ViolationsByName, AreTheWorstOfAllNodes) {
  const ShootingProblem problem = two_knots();
  const Eigen::VectorXd values = Eigen::VectorXd{{0.5, 0.5, -2.5, -2.5, 1.25, 1.25}};
  const auto hard = violations_by_name(problem, values);
  ASSERT_EQ(hard.size(), 2u);
  EXPECT_EQ(hard[0].name, "box");
  EXPECT_NEAR(hard[0].value, 1.5, 1e-15);
  EXPECT_EQ(hard[0].node, 1);
  EXPECT_EQ(hard[1].name, "terminal/box");
  EXPECT_NEAR(hard[1].value, 0.25, 1e-15);
  EXPECT_EQ(hard[1].node, 2);
  const auto soft = soft_violations(problem, walk(problem), values);
  ASSERT_EQ(soft.size(), 2u);
  EXPECT_EQ(soft[0].name, "soft");
  EXPECT_NEAR(soft[0].value, 0.5, 1e-15);
  EXPECT_EQ(soft[0].node, 0);
  EXPECT_NEAR(soft[1].value, 1.25, 1e-15);
  const auto none = violations_by_name(problem, Eigen::VectorXd::Zero(6));
  for (const ConstraintViolation& v : none) EXPECT_EQ(v.node, -1) << v.name;
}

/// A zero row of a function that failed.
class FailedResidual : public ResidualBase<FailedResidual> {
 public:
  explicit FailedResidual(std::string name)
      : ResidualBase({{1, {0}}}, 0, false), name_(std::move(name)) {}
  std::vector<std::string> failed_functions() const override { return {name_, "shared"}; }
  template <class S>
  void evaluate_as(const ResidualInput<S>&, S* r) const {
    r[0] = S(0.0);
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>&, S* r, S* jacobian) const {
    r[0] = jacobian[0] = S(0.0);
  }

 private:
  std::string name_;
};

TEST(FailedFunctions, ListAllTermsOfAllPhasesOnce) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const auto system = linear_system(one, one, Eigen::VectorXd::Zero(1));
  const auto phase_of = [&](Integrator integrator, const std::string& name) {
    auto model = std::make_shared<KnotModel>(system, integrator);
    model->add_cost("cost", std::make_shared<FailedResidual>(name + " cost"), {});
    model->add_constraint(make_constraint("row", std::make_shared<FailedResidual>(name + " row"),
                                          ConstraintKind::bounds));
    return Phase{.name = name,
                 .model = model,
                 .dt = {1},
                 .cost_scale = {1},
                 .parameters = std::vector<double>(model->parameter_count(), 0.0)};
  };
  const ShootingProblem problem(
      {0}, {phase_of(Integrator::discrete, "first"), phase_of(Integrator::discrete, "second")},
      phase_of(Integrator::none, "end"));
  EXPECT_EQ(failed_functions(problem),
            (std::vector<std::string>{"first cost", "shared", "first row", "second cost",
                                      "second row", "end cost", "end row"}));
  EXPECT_TRUE(failed_functions(two_knots()).empty());
}

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
