// Free controls of two masses on lines with independent pushes.
#include "analysis/findings/free_control.hpp"

#include <gtest/gtest.h>

#include "support/small_problems.hpp"
#include "support/steps.hpp"

namespace conddp {
namespace {

/// Three knots of the masses; without further terms, both pushes are free.
struct Pushes {
  Memory memory = Memory::none;
  std::shared_ptr<const System> system = double_integrator(2);
  std::shared_ptr<KnotModel> model =
      std::make_shared<KnotModel>(step_with(system, Integrator::rk4, memory));
  bool instant = false;  ///< the first knot takes no time
  double weight = 1;     ///< of costs

  int ndx() const { return model->ndx(); }
  void bound(int control, double lower, double upper) {
    std::vector<double> low = {-1, -1}, up = {1, 1};
    low[control] = lower;
    up[control] = upper;
    model->set_control_bounds(low, up);
  }
  /// r = row-wise sums of these columns of (x, u), in blocks of one row.
  std::shared_ptr<const Residual> rows_of(const std::vector<std::vector<int>>& rows) const {
    std::vector<LinearCombination> list;
    for (const std::vector<int>& columns : rows) {
      LinearCombination row;
      for (const int column : columns) {
        const bool of_control = column >= ndx();
        row.terms.push_back({1, of_control, of_control ? column - ndx() : column, column});
      }
      list.push_back(row);
    }
    return combination_residual(ndx(), list);
  }
  std::string found() const {
    const std::size_t numbers = model->parameter_count();
    std::vector<Phase> phases;
    for (int k = 0; k < 3; ++k) {
      std::vector<double> parameters(numbers, 1.0);
      for (const CostTerm& term : model->costs()) parameters[term.weight] = weight;
      phases.push_back({.name = "phase" + std::to_string(k),
                        .model = model,
                        .dt = {0.1},
                        .cost_scale = {1},
                        .parameters = parameters,
                        .instant = instant && k == 0});
    }
    const ShootingProblem problem(
        std::vector<double>(model->nx(), 0.0), std::move(phases),
        {.name = "end",
         .model = std::make_shared<KnotModel>(step_with(system, Integrator::none, memory)),
         .dt = {0},
         .cost_scale = {1}});
    const auto control = free_control(problem);
    return control ? control->name + " in " + control->phase + " " + std::to_string(control->knot)
                   : "none";
  }
};

std::string name_of(const Pushes& pushes, int control) {
  return pushes.system->control_columns()[control].name;
}

TEST(FreeControl, IsFirstOfFirstKnotWithDuration) {
  Pushes pushes;
  EXPECT_EQ(pushes.found(), name_of(pushes, 0) + " in phase0 0");
  pushes.instant = true;
  EXPECT_EQ(pushes.found(), name_of(pushes, 0) + " in phase1 1");
}

TEST(FreeControl, IsUnboundedOnBothSides) {
  for (const int control : {0, 1}) {
    Pushes pushes;
    pushes.bound(control, -testing::kFree, testing::kFree);
    EXPECT_EQ(pushes.found(), name_of(pushes, control) + " in phase0 0");
    pushes.bound(control, -3, testing::kFree);
    EXPECT_EQ(pushes.found(), "none") << control;
    pushes.bound(control, -testing::kFree, 3);
    EXPECT_EQ(pushes.found(), "none") << control;
  }
}

TEST(FreeControl, IsReadByNoConstraint) {
  Pushes pushes;
  const int u0 = pushes.ndx(), u1 = u0 + 1;
  pushes.model->add_constraint(
      make_constraint("first", pushes.rows_of({{0}, {1, u0}}), ConstraintKind::bounds));
  EXPECT_EQ(pushes.found(), name_of(pushes, 1) + " in phase0 0");
  pushes.model->add_constraint(
      make_constraint("second", pushes.rows_of({{u1}}), ConstraintKind::bounds));
  EXPECT_EQ(pushes.found(), "none");
}

TEST(FreeControl, IgnoresRowsOfZeroWeight) {
  const auto with_cost = [](const std::vector<std::vector<int>>& rows, Activation activation,
                            double weight = 1) {
    Pushes pushes;
    pushes.bound(0, -testing::kFree, testing::kFree);
    pushes.weight = weight;
    pushes.model->add_cost("cost", pushes.rows_of(rows), std::move(activation));
    return pushes.found() == "none";
  };
  constexpr int kPush = 4;
  EXPECT_TRUE(with_cost({{kPush}}, {}));
  EXPECT_FALSE(with_cost({{kPush}}, {}, 0));
  EXPECT_FALSE(with_cost({{kPush + 1}, {2}}, {}));
  EXPECT_TRUE(with_cost({{0}, {1}, {2, kPush}}, {.weights = {0, 0, 1}}));
  EXPECT_FALSE(with_cost({{0}, {1}, {2, kPush}}, {.weights = {1, 1, 0}}));
  EXPECT_TRUE(with_cost({{kPush}, {1}, {2}}, {.weights = {1, 0, 0}}));
  EXPECT_FALSE(with_cost({{kPush}, {1}, {2}}, {.weights = {0, 1, 1}}));
  EXPECT_TRUE(with_cost({{0}, {kPush}, {2}}, {.weights = {0, 2, 0}}));
  EXPECT_FALSE(with_cost({{0}, {kPush}, {2}}, {.weights = {3, 0, 3}}));
}

// A linear control at the start of a knot is part of the state.
TEST(FreeControl, LinearControlWithCostlyStartIsNotFree) {
  for (const int control : {0, 1}) {
    Pushes pushes{.memory = Memory::linear};
    pushes.bound(control, -testing::kFree, testing::kFree);
    EXPECT_EQ(pushes.found(), name_of(pushes, control) + " in phase0 0");
    pushes.model->add_cost("place", pushes.rows_of({{1}}), {});
    EXPECT_EQ(pushes.found(), name_of(pushes, control) + " in phase0 0");
    pushes.model->add_cost("push", pushes.rows_of({{4 + control}}), {});
    EXPECT_EQ(pushes.found(), "none") << control;
  }
}

}  // namespace
}  // namespace conddp
