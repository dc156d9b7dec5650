// Regulators about equilibria and the conditions of model-predictive control, for a linear system
// with known figures.
#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "analysis/terminal/terminal_set.hpp"
#include "support/block_on_slides.hpp"
#include "support/expression_systems.hpp"
#include "support/regulated_mass.hpp"

namespace conddp {
namespace {

using testing::mass_stage;
using testing::pushed_mass;
using testing::regulated;
using testing::stage_of;

/// The exact double integrator with force limit 1. Reference figures come from the discrete Riccati
/// equation of another program.
class BoundedMass : public ::testing::Test {
 protected:
  TerminalConditions conditions(double level, double weight = 1) const {
    return check_terminal_conditions(own_, {.weight = weight, .level = level});
  }

  const TerminalIngredients own_ = *regulated(mass_stage(pushed_mass(1), {-1}, {1})).ingredients;
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
  EXPECT_NEAR(found.conditions[3].figure, 1, 1e-9);  // the cost-to-go belongs to the regulator
  EXPECT_EQ(found.decrease.level, kLargest);
  EXPECT_NEAR(found.decrease.factor, 1, 1e-9);
}

// At 16 times the level, the control reaches 4; two levels below, it reaches 1.
TEST_F(BoundedMass, ExceedsItsBoundsInALargerSet) {
  const TerminalConditions found = conditions(16 * kLargest);
  EXPECT_FALSE(found.hold());
  EXPECT_FALSE(found.conditions[1].holds);
  EXPECT_NEAR(found.conditions[1].figure, 3, 0.01);
  EXPECT_LE(found.conditions[1].figure, 3);
  EXPECT_DOUBLE_EQ(found.conditions[1].level, kLargest);
  for (const int i : {0, 2, 3}) EXPECT_TRUE(found.conditions[i].holds) << i;
}

TEST_F(BoundedMass, DecreasesByStageCostForLargeWeights) {
  const TerminalConditions found = conditions(kLargest, 0.5);
  EXPECT_FALSE(found.conditions[3].holds);
  EXPECT_NEAR(found.conditions[3].figure, 0.5, 1e-9);
  EXPECT_EQ(found.conditions[3].level, 0);
  EXPECT_EQ(found.decrease.level, kLargest);
  EXPECT_NEAR(found.decrease.factor, 2, 1e-8);
  EXPECT_NEAR(conditions(kLargest, 2).decrease.factor, 1, 1e-12);
}

// A terminal cost with zero weight never decreases; no factor helps.
TEST_F(BoundedMass, ZeroWeightNeverDecreases) {
  const TerminalConditions found = conditions(kLargest, 0);
  EXPECT_EQ(found.conditions[3].figure, 0);
  EXPECT_EQ(found.decrease.level, 0);
  EXPECT_EQ(found.decrease.factor, 0);
}

TEST_F(BoundedMass, EmptySetIsCheckedAtTheEquilibrium) {
  TerminalConditions found = conditions(0);
  ASSERT_EQ(found.conditions.size(), 2u);
  EXPECT_EQ(found.samples, 0);
  EXPECT_TRUE(found.hold());
  EXPECT_EQ(found.conditions[0].figure, 0);
  EXPECT_EQ(found.conditions[1].figure, 0);
}

TEST(TerminalIngredients, RedistributesForceSharesBeyondBounds) {
  const auto held = [](std::vector<double> lower, std::vector<double> upper) {
    const TerminalResult found =
        regulated(mass_stage(pushed_mass(2, 3), std::move(lower), std::move(upper)));
    EXPECT_TRUE(found.ingredients) << found.fault;
    return found.ingredients ? found.ingredients->u : Eigen::VectorXd();
  };
  EXPECT_TRUE(held({-4, -4}, {4, 4}).isApprox(Eigen::Vector2d(1.5, 1.5), 1e-12));
  EXPECT_TRUE(held({-1, -4}, {1, 4}).isApprox(Eigen::Vector2d(1, 2), 1e-12));
  EXPECT_TRUE(held({-4, -1}, {4, 1}).isApprox(Eigen::Vector2d(2, 1), 1e-12));
}

TEST(TerminalIngredients, NamesForceThatBoundsExclude) {
  const TerminalResult found = regulated(mass_stage(pushed_mass(2, 3), {-0.5, -2}, {1, 1.2}));
  EXPECT_FALSE(found.ingredients);
  EXPECT_EQ(
      found.fault,
      "the control that holds the state exceeds its bounds: 'u/0' is 1.5, and may be -0.5 to 1");
}

TEST(TerminalIngredients, UnsupportedStateIsNoEquilibrium) {
  const Phase phase = mass_stage(pushed_mass(1), {-1}, {1});
  const TerminalResult found =
      find_terminal_ingredients({phase, 0, {0, 2}, Eigen::VectorXd::Zero(1)}, {"place", "speed"});
  EXPECT_FALSE(found.ingredients);
  EXPECT_NE(found.fault.find("'place' changes by 2 in a second"), std::string::npos) << found.fault;
}

// Costs at x̄ and ū do not change a linear regulator; they are reported.
TEST(TerminalIngredients, IncludeCostAndSlopeAtEquilibrium) {
  const auto at = [](std::vector<double> reference) {
    return *regulated(stage_of(pushed_mass(1, 2),
                               {.reference = std::move(reference), .state = {1, 3}}, {-5}, {5}))
                .ingredients;
  };
  const TerminalIngredients plain = at({0, 0}), off = at({0.5, -0.25});
  EXPECT_NEAR(off.u[0], 2, 1e-12);
  EXPECT_NEAR(plain.cost, 0.1 * 0.5 * 0.1 * 4, 1e-14);
  EXPECT_NEAR(off.cost, plain.cost + 0.1 * 0.5 * (0.25 + 3 * 0.0625), 1e-14);
  EXPECT_LT((off.gradient - Eigen::Vector3d(-0.05, 0.075, 0.02)).norm(), 1e-13);
  EXPECT_LT((off.P - plain.P).norm(), 1e-12);
  EXPECT_LT((off.K - plain.K).norm(), 1e-12);
  // The stage cost of condition A4 excludes both.
  const TerminalConditions found = check_terminal_conditions(off, {.level = 0.01, .samples = 50});
  EXPECT_NEAR(found.conditions[3].figure, 1, 1e-7);
  EXPECT_TRUE(found.conditions[3].holds);
}

TEST(TerminalIngredients, ComeFromTheRequestedKnot) {
  const Phase light = mass_stage(pushed_mass(1), {-1}, {1});
  Phase both = light;
  both.dt.push_back(0.2);
  both.cost_scale.push_back(0.3);
  both.parameters.insert(both.parameters.end(), light.parameters.begin(), light.parameters.end());
  both.parameters.back() = 0.7;
  Phase heavy = light;
  heavy.dt = {0.2};
  heavy.cost_scale = {0.3};
  heavy.parameters.back() = 0.7;
  const auto P = [](const Phase& phase, int knot) { return regulated(phase, knot).ingredients->P; };
  EXPECT_EQ(P(both, 0), P(light, 0));
  EXPECT_EQ(P(both, 1), P(heavy, 0));
  EXPECT_GT((P(light, 0) - P(heavy, 0)).norm(), 0.1);
  EXPECT_EQ(regulated(both, 1).ingredients->knot->knot(0).dt, 0.2);
}

// A remembered control decays at once.
TEST(TerminalIngredients, RememberTheControlThatHoldsTheState) {
  const auto with = [](Memory memory) {
    const TerminalResult found = regulated(stage_of(
        pushed_mass(2, 3), {.reference = {0, 0}, .state = {1, 1}}, {-1, -4}, {1, 4}, {}, memory));
    EXPECT_TRUE(found.ingredients) << found.fault;
    return *found.ingredients;
  };
  const TerminalIngredients own = with(Memory::previous), plain = with(Memory::none);
  EXPECT_EQ(own.x, (std::vector<double>{0, 0, own.u[0], own.u[1]}));
  EXPECT_LT((own.u - Eigen::Vector2d(1, 2)).norm(), 1e-12);
  EXPECT_LT(own.drift, 1e-13);
  EXPECT_LT((own.P.topLeftCorner<2, 2>() - plain.P).norm(), 1e-12);
  EXPECT_LT((own.K.leftCols<2>() - plain.K).norm(), 1e-12);
  EXPECT_TRUE(own.P.rightCols<2>().isZero(0) && own.P.bottomRows<2>().isZero(0));
  EXPECT_LT(own.K.rightCols<2>().norm(), 1e-12);
  EXPECT_EQ(own.knot->initial_state(), own.x);
}

/// P of a mass under semi-implicit Euler of 0.1 s, with Q = I and R = 1 as rates.
Eigen::MatrixXd cost_to_go_of_mass(double mass) {
  const double h = 0.1;
  const Eigen::Matrix2d A{{1, h}, {0, 1}};
  return solve_regulator({.A = A,
                          .B = Eigen::Vector2d(h * h, h) / mass,
                          .Q = h * Eigen::Matrix2d::Identity(),
                          .R = Eigen::MatrixXd::Constant(1, 1, h),
                          .S = Eigen::Vector2d::Zero()})
      .regulator->P;
}

// The contact holds the block along z: 4 kg move along x, 3 kg along y, and z is fixed.
TEST(TerminalIngredients, UseTangentSpaceOfTheContacts) {
  for (const bool remembers : {false, true}) {
    const auto system = testing::block_system({{.name = "rail", .kind = ContactKind::normal}});
    const auto model =
        std::make_shared<KnotModel>(step_with(system, Integrator::semi_implicit_euler, remembers));
    model->add_cost("state", coordinate_residual(model->manifold(), {0, 1, 2, 3, 4, 5}), {});
    model->add_cost("effort", control_residual(model->ndx(), 3), {});
    Phase phase{.name = "rail", .model = model, .dt = {0.1}, .cost_scale = {0.1}};
    phase.parameters = {0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1};
    const TerminalResult found = regulated(phase);
    ASSERT_TRUE(found.ingredients) << found.fault;
    const TerminalIngredients& own = *found.ingredients;
    const int n = remembers ? 9 : 6;
    ASSERT_EQ(own.tangent.rows(), n);
    ASSERT_EQ(own.tangent.cols(), n - 2);
    EXPECT_LT(
        (own.tangent.transpose() * own.tangent - Eigen::MatrixXd::Identity(n - 2, n - 2)).norm(),
        1e-14);
    EXPECT_LT(own.tangent.row(2).norm() + own.tangent.row(5).norm(), 1e-14);
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(n, n);
    for (const auto& [axis, mass] : {std::pair{0, 4.0}, {1, 3.0}}) {
      const std::vector<int> places = {axis, 3 + axis};
      expected(places, places) = cost_to_go_of_mass(mass);
    }
    EXPECT_LT((own.P - expected).norm(), 1e-9);
    EXPECT_LT(own.K.row(2).norm(), 1e-12);
    EXPECT_LT(own.u.norm(), 1e-12);
  }
}

// u + u²/2 = 3/2 at u = 1: Newton steps of the control continue while they make progress.
TEST(TerminalIngredients, SupportNonlinearControlEffects) {
  const auto system = expression_system({.kind = SystemKind::first_order,
                                         .states = {{"x"}},
                                         .controls = {{"u", "1"}},
                                         .equations = {{"x", "u + u^2/2 - 1.5 - x"}}});
  const auto model = std::make_shared<KnotModel>(system, Integrator::rk4);
  model->add_cost("state", coordinate_residual(model->manifold(), {0}), {});
  model->add_cost("effort", control_residual(1, 1), {});
  const Phase phase{
      .name = "knot", .model = model, .dt = {0.1}, .cost_scale = {0.1}, .parameters = {0, 1, 0, 1}};
  const TerminalResult found = regulated(phase);
  ASSERT_TRUE(found.ingredients) << found.fault;
  EXPECT_NEAR(found.ingredients->u[0], 1, 1e-14);
  EXPECT_LT(found.ingredients->drift, 1e-14);
}

TEST(TerminalIngredients, DoNotExistForNonFiniteStates) {
  const Phase phase = mass_stage(pushed_mass(1), {-1}, {1});
  const TerminalResult found = find_terminal_ingredients(
      {phase, 0, {std::nan(""), 0}, Eigen::VectorXd::Zero(1)}, {"x0", "x1"});
  EXPECT_FALSE(found.ingredients);
  EXPECT_NE(found.fault.find("is not finite at this state"), std::string::npos) << found.fault;
}

/// Fault of a system x⁺ = A x + B u with these weights.
std::string fault_of(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                     std::vector<double> weights, double effort = 0.1) {
  const Eigen::Index n = A.rows(), m = B.cols();
  const TerminalResult found = regulated(stage_of(
      linear_system(A, B, Eigen::VectorXd::Zero(n)),
      {.reference = std::vector<double>(n, 0.0), .state = std::move(weights), .effort = effort},
      std::vector<double>(m, -testing::kFree), std::vector<double>(m, testing::kFree)));
  EXPECT_FALSE(found.ingredients);
  return found.fault;
}

// Systems in transformed coordinates: the mode's states are those that participate in it.
TEST(TerminalIngredients, NeedControllableAndObservableModes) {
  // (x1, x3) rotate without decay, x0 and x2 decay; the control moves only x0.
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(4, 4);
  A.diagonal() << 0.5, 0.6, 0.25, 0.6;
  A(1, 3) = -0.8;
  A(3, 1) = 0.8;
  const Eigen::MatrixXd first = Eigen::MatrixXd::Identity(4, 1);
  EXPECT_EQ(fault_of(A, first, {1, 1, 1, 1}),
            "no control moves the mode with eigenvalue 0.6 ± 0.8i of 'x1', 'x3', which does not "
            "decay");
  const Eigen::MatrixXd all = Eigen::MatrixXd::Identity(4, 4);
  EXPECT_EQ(
      fault_of(A, all, {1, 0, 1, 0}),
      "the running cost does not depend on the mode with eigenvalue 0.6 ± 0.8i of 'x1', 'x3', "
      "which does not decay");
  EXPECT_NE(fault_of(A, all, {1, 1, 1, 1}, 0).find("leaves a direction of the control free"),
            std::string::npos);
  // Largest share first.
  const Eigen::MatrixXd grows{{1.05, 0}, {1, 0.5}};
  EXPECT_EQ(fault_of(grows, Eigen::MatrixXd::Zero(2, 1), {1, 1}),
            "no control moves the mode with eigenvalue 1.05 of 'x0', which does not decay");
}

/// x⁺ = 1.2 x + 0.5 u: every boundary sample of a set is one of its two ends.
struct ScalarStage {
  explicit ScalarStage(std::vector<testing::StageConstraint> constraints,
                       double lower = -testing::kFree, double upper = testing::kFree)
      : own(*regulated(stage_of(linear_system(Eigen::MatrixXd::Constant(1, 1, 1.2),
                                              Eigen::MatrixXd::Constant(1, 1, 0.5),
                                              Eigen::VectorXd::Zero(1)),
                                {.reference = {0}, .state = {1}}, {lower}, {upper},
                                std::move(constraints)))
                 .ingredients),
        p(own.P(0, 0)),
        k(own.K(0, 0)) {}

  TerminalConditions at(double level, int samples = 20) const {
    return check_terminal_conditions(own, {.level = level, .samples = samples});
  }

  TerminalIngredients own;
  double p, k;
};

testing::StageConstraint interval(const std::shared_ptr<const Residual>& residual, double lower,
                                  double upper, Softness softness = Softness::hard) {
  testing::StageConstraint constraint{
      make_constraint("interval", residual, ConstraintKind::bounds, 1, softness),
      {0, lower, upper, 1}};
  if (softness != Softness::hard) constraint.numbers.push_back(1);
  return constraint;
}

TEST(TerminalConditions, MeasureConstraintsAtTheEndsOfTheSet) {
  const auto state = coordinate_residual(StateManifold::flat(1), {0});
  const ScalarStage on_state({interval(state, -0.3, 0.5)});
  const double level = 0.36 * on_state.p;  // from −0.6 to 0.6
  const TerminalConditions found = on_state.at(level);
  EXPECT_FALSE(found.hold());
  EXPECT_EQ(found.level, level);
  EXPECT_EQ(found.samples, 20);
  EXPECT_FALSE(found.conditions[0].holds);
  EXPECT_NEAR(found.conditions[0].figure, 0.3, 1e-12);
  EXPECT_EQ(found.conditions[0].level, level / 4);  // from −0.3 on
  for (const int i : {1, 2, 3}) EXPECT_TRUE(found.conditions[i].holds) << i;
  EXPECT_EQ(found.conditions[1].figure, 0);
  // A soft constraint costs more but is not a condition.
  EXPECT_EQ(ScalarStage({interval(state, -0.3, 0.5, Softness::l1)}).at(level).conditions[0].figure,
            0);

  const auto control = control_residual(1, 1);
  const ScalarStage on_control({interval(control, -0.25, 4)});
  const TerminalConditions pushed = on_control.at(level);
  EXPECT_EQ(pushed.conditions[0].figure, 0);
  EXPECT_NEAR(pushed.conditions[1].figure, 0.6 * std::abs(on_control.k) - 0.25, 1e-12);
  for (const bool lower : {true, false}) {
    const ScalarStage bounded({}, lower ? -0.25 : -4, lower ? 4 : 0.25);
    EXPECT_NEAR(bounded.at(level).conditions[1].figure, 0.6 * std::abs(bounded.k) - 0.25, 1e-12);
  }
}

TEST(TerminalConditions, MeasureTheStepOfTheRegulator) {
  const ScalarStage stage({});
  const double kept = 1.2 - 0.5 * stage.k;
  const TerminalConditions found = stage.at(0.5);
  EXPECT_NEAR(found.conditions[2].figure, kept * kept, 1e-12);
  EXPECT_EQ(found.conditions[2].level, 0.5);
  EXPECT_NEAR(stage.at(0.5, 1).conditions[2].figure, kept * kept, 1e-12) << "of one sample";
  EXPECT_NEAR(found.conditions[3].figure, 1, 1e-12);
}

TEST(TerminalConditions, UnboundedSetsAreSampledWithinATenth) {
  EXPECT_NEAR(ScalarStage({}).at(testing::kFree).level, 0.01 * ScalarStage({}).p, 1e-15);
  const TerminalIngredients mass = *regulated(mass_stage(pushed_mass(1), {-1}, {1})).ingredients;
  const Eigen::Matrix2d inverse = mass.P.inverse();
  EXPECT_NEAR(check_terminal_conditions(mass, {.level = testing::kFree, .samples = 3}).level,
              0.01 / inverse.diagonal().maxCoeff(), 1e-14);
}

TEST(TerminalConditions, EquilibriumSetChecksItsConstraints) {
  const auto state = coordinate_residual(StateManifold::flat(1), {0});
  const TerminalConditions off = ScalarStage({interval(state, 0.1, 1)}).at(0);
  ASSERT_EQ(off.conditions.size(), 2u);
  EXPECT_FALSE(off.hold());
  EXPECT_FALSE(off.conditions[0].holds);
  EXPECT_NEAR(off.conditions[0].figure, 0.1, 1e-15);
  EXPECT_TRUE(off.conditions[1].holds);
  const TerminalConditions pushed = ScalarStage({interval(control_residual(1, 1), -1, -0.2)}).at(0);
  EXPECT_TRUE(pushed.conditions[0].holds);
  EXPECT_FALSE(pushed.conditions[1].holds);
  EXPECT_NEAR(pushed.conditions[1].figure, 0.2, 1e-15);
}

// The second state costs nothing and is not sampled; without any cost the set is empty.
TEST(TerminalConditions, IgnoreCostlessDirections) {
  const auto second = coordinate_residual(StateManifold::flat(2), {1});
  const auto system = linear_system(Eigen::Vector2d(0.5, 0.9).asDiagonal().toDenseMatrix(),
                                    Eigen::Matrix2d{{0.5, 0}, {0, 0.5}}, Eigen::Vector2d::Zero());
  const auto conditions = [&](std::vector<double> weights) {
    return check_terminal_conditions(
        *regulated(stage_of(system, {.reference = {0, 0}, .state = std::move(weights)}, {-1, -1},
                            {1, 1}, {interval(second, -1e-3, 1e-3)}))
             .ingredients,
        {.level = 1, .samples = 20});
  };
  const TerminalConditions one = conditions({1, 0}), none = conditions({0, 0});
  ASSERT_EQ(one.conditions.size(), 4u);
  EXPECT_EQ(one.conditions[0].figure, 0);
  EXPECT_TRUE(none.conditions.empty());
  EXPECT_EQ(none.samples, 0);
}

}  // namespace
}  // namespace conddp
