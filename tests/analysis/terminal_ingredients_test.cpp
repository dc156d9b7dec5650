// Regulators about equilibria, and what model-predictive control asks of them, for a linear system
// whose figures are known.
#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "analysis/terminal/terminal_conditions.hpp"
#include "ocp/residuals/residuals.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

/// A mass that forces move which add up, exact over 0.1 s; `pull` works against them.
std::shared_ptr<const System> mass(int forces, double pull = 0) {
  const Eigen::Matrix2d A{{1, 0.1}, {0, 1}};
  const Eigen::MatrixXd B = Eigen::Vector2d(0.005, 0.1).replicate(1, forces);
  return linear_system(A, B, -pull * Eigen::Vector2d(0.005, 0.1));
}

/// A knot of it with Q = I and R = 0.1 as rates.
Phase knot_of(const std::shared_ptr<const System>& system, std::vector<double> lower,
              std::vector<double> upper) {
  const int nu = system->nu();
  const auto model = std::make_shared<KnotModel>(system, Integrator::discrete);
  model->add_cost("state", state_residual(model->manifold()), {});
  model->add_cost("effort", control_residual(model->ndx(), nu), {});
  model->set_control_bounds(std::move(lower), std::move(upper));
  Phase phase{.name = "knot", .model = model, .dt = {0.1}, .cost_scale = {0.1}};
  phase.parameters = {0, 0, 1};  // references, then the weight, of each cost
  phase.parameters.resize(phase.parameters.size() + nu);
  phase.parameters.push_back(0.1);
  return phase;
}

TerminalResult regulated(const Phase& phase) {
  return find_terminal_ingredients({phase, 0, {0, 0}, Eigen::VectorXd::Zero(phase.model->nu())},
                                   {"place", "speed"});
}

/// The exact double integrator under a force of at most 1: figures by the discrete Riccati
/// equation, from another program.
class BoundedMass : public ::testing::Test {
 protected:
  TerminalConditions conditions(double level, double weight = 1) const {
    return check_terminal_conditions(own_, {.weight = weight, .level = level});
  }

  const TerminalIngredients own_ = *regulated(knot_of(mass(1), {-1}, {1})).ingredients;
  static constexpr double kLargest = 0.0387749825794;  ///< the largest level within the bounds
};

TEST_F(BoundedMass, HasItsKnownRegulatorAndSet) {
  EXPECT_NEAR(own_.P(0, 0), 1.3317224441130, 1e-12);
  EXPECT_NEAR(own_.P(0, 1), 0.3201562118716, 1e-12);
  EXPECT_NEAR(own_.P(1, 1), 0.4603514023781, 1e-12);
  EXPECT_NEAR(own_.K(0, 0), 2.5857008966598, 1e-12);
  EXPECT_NEAR(own_.K(0, 1), 3.4434359178453, 1e-12);
  EXPECT_NEAR(largest_terminal_set(own_).level, kLargest, 1e-12);
  EXPECT_EQ(own_.cost, 0);
  EXPECT_NEAR(own_.drift, 0, 1e-15);
}

TEST_F(BoundedMass, MeetsAllConditionsInItsLargestSet) {
  const TerminalConditions found = conditions(kLargest);
  EXPECT_TRUE(found.hold());
  ASSERT_EQ(found.conditions.size(), 4u);
  for (const TerminalCondition& c : found.conditions) {
    EXPECT_TRUE(c.holds) << c.name;
    EXPECT_EQ(c.level, kLargest) << c.name;
  }
  EXPECT_EQ(found.conditions[0].figure, 0);
  EXPECT_LE(found.conditions[1].figure, 0);
  EXPECT_LT(found.conditions[2].figure, 1);
  EXPECT_NEAR(found.conditions[3].figure, 1, 1e-9);  // the cost-to-go is the regulator's
  EXPECT_EQ(found.decrease.level, kLargest);
  EXPECT_NEAR(found.decrease.factor, 1, 1e-9);
}

// At 16 times the level the control is up to 4; two levels below it is up to 1.
TEST_F(BoundedMass, ExceedsItsBoundsInALargerSet) {
  const TerminalConditions found = conditions(16 * kLargest);
  EXPECT_FALSE(found.hold());
  EXPECT_FALSE(found.conditions[1].holds);
  EXPECT_NEAR(found.conditions[1].figure, 3, 0.01);
  EXPECT_LE(found.conditions[1].figure, 3);
  EXPECT_DOUBLE_EQ(found.conditions[1].level, kLargest);
  for (const int i : {0, 2, 3}) EXPECT_TRUE(found.conditions[i].holds) << i;
}

TEST_F(BoundedMass, DecreasesByTheStageCostWhereItsWeightIsLargeEnough) {
  const TerminalConditions found = conditions(kLargest, 0.5);
  EXPECT_FALSE(found.conditions[3].holds);
  EXPECT_NEAR(found.conditions[3].figure, 0.5, 1e-9);
  EXPECT_EQ(found.conditions[3].level, 0);
  EXPECT_EQ(found.decrease.level, kLargest);
  EXPECT_NEAR(found.decrease.factor, 2, 1e-8);
  EXPECT_NEAR(conditions(kLargest, 2).decrease.factor, 1, 1e-12);
}

// A terminal cost without weight decreases by nothing: no factor helps.
TEST_F(BoundedMass, DecreasesByNothingWithoutWeight) {
  const TerminalConditions found = conditions(kLargest, 0);
  EXPECT_EQ(found.conditions[3].figure, 0);
  EXPECT_EQ(found.decrease.level, 0);
  EXPECT_EQ(found.decrease.factor, 0);
}

TEST_F(BoundedMass, IsJudgedAtTheEquilibriumAloneWhereTheSetIsThat) {
  TerminalConditions found = conditions(0);
  ASSERT_EQ(found.conditions.size(), 2u);
  EXPECT_EQ(found.samples, 0);
  EXPECT_TRUE(found.hold());
  EXPECT_EQ(found.conditions[0].figure, 0);
  EXPECT_EQ(found.conditions[1].figure, 0);
}

TEST(TerminalIngredients, SharesOfAForceThatExceedTheirBoundGoToTheOthers) {
  const auto held = [](std::vector<double> lower, std::vector<double> upper) {
    const TerminalResult found = regulated(knot_of(mass(2, 3), std::move(lower), std::move(upper)));
    EXPECT_TRUE(found.ingredients) << found.fault;
    return found.ingredients ? found.ingredients->u : Eigen::VectorXd();
  };
  EXPECT_TRUE(held({-4, -4}, {4, 4}).isApprox(Eigen::Vector2d(1.5, 1.5), 1e-12));
  EXPECT_TRUE(held({-1, -4}, {1, 4}).isApprox(Eigen::Vector2d(1, 2), 1e-12));
  EXPECT_TRUE(held({-4, -1}, {4, 1}).isApprox(Eigen::Vector2d(2, 1), 1e-12));
}

TEST(TerminalIngredients, AForceThatBoundsDoNotAllowIsNamedWithThem) {
  const TerminalResult found = regulated(knot_of(mass(2, 3), {-0.5, -2}, {1, 1.2}));
  EXPECT_FALSE(found.ingredients);
  EXPECT_EQ(
      found.fault,
      "the control that holds the state exceeds its bounds: 'u/0' is 1.5, and may be -0.5 to 1");
}

TEST(TerminalIngredients, AStateThatNothingHoldsIsNoEquilibrium) {
  const Phase phase = knot_of(mass(1), {-1}, {1});
  const TerminalResult found =
      find_terminal_ingredients({phase, 0, {0, 2}, Eigen::VectorXd::Zero(1)}, {"place", "speed"});
  EXPECT_FALSE(found.ingredients);
  EXPECT_NE(found.fault.find("'place' changes by 2 in a second"), std::string::npos) << found.fault;
}

}  // namespace
}  // namespace conddp
