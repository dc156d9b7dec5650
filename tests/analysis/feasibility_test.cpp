// Hand-computed distances, products, and signs of bounds, cones, and pairs.
#include "analysis/certificate/feasibility.hpp"

#include <gtest/gtest.h>

#include "analysis/certificate/certificate.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

constexpr double kOpenEnd = testing::kFree;

/// One step x⁺ = x + u of n coordinates with a constraint on its control (soft if weighted) and
/// control bounds.
ShootingProblem one_step_of(int n, ConstraintKind kind, const std::vector<double>& bounds,
                            double weight = 0, std::vector<double> control_lower = {},
                            std::vector<double> control_upper = {}) {
  const auto system = linear_system(Eigen::MatrixXd::Identity(n, n),
                                    Eigen::MatrixXd::Identity(n, n), Eigen::VectorXd::Zero(n));
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->add_constraint(make_constraint("rows", control_residual(n, n), kind, 1,
                                          weight > 0 ? Softness::l1 : Softness::hard));
  if (!control_lower.empty()) running->set_control_bounds(control_lower, control_upper);
  std::vector<double> parameters(n, 0.0);
  parameters.insert(parameters.end(), bounds.begin(), bounds.end());
  parameters.push_back(1);
  if (weight > 0) parameters.push_back(weight);
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "go", .model = running, .dt = {1}, .cost_scale = {1}, .parameters = parameters});
  return ShootingProblem(std::vector<double>(n, 0.0), std::move(phases),
                         {.name = "end",
                          .model = std::make_shared<KnotModel>(system, Integrator::none),
                          .dt = {0},
                          .cost_scale = {1}});
}

Eigen::VectorXd numbers(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Feasibility feasibility_of(const ShootingProblem& problem, const std::vector<double>& values,
                           const std::vector<double>& multipliers) {
  SolutionClaims claims(problem);
  claims.multipliers = numbers(multipliers);
  return measure_feasibility(problem, claims, numbers(values));
}

TEST(Feasibility, RowViolationIsDistanceFromBounds) {
  const ShootingProblem problem =
      one_step_of(3, ConstraintKind::bounds, {0, -kOpenEnd, 1, 2, 3, 1});
  EXPECT_EQ(feasibility_of(problem, {1, 2, 1}, {0, 0, 0}).violation.value, 0);
  const Feasibility below = feasibility_of(problem, {-0.25, 2, 1}, {0, 0, 0});
  EXPECT_NEAR(below.violation.value, 0.25, 1e-15);
  EXPECT_EQ(below.violation.knot, 0);
  EXPECT_EQ(constraint_of(below.violation), 0);
  EXPECT_NEAR(feasibility_of(problem, {1, 3.5, 1}, {0, 0, 0}).violation.value, 0.5, 1e-15);
  EXPECT_NEAR(feasibility_of(problem, {2.125, 3, 1}, {0, 0, 0}).violation.value, 0.125, 1e-15);
  EXPECT_NEAR(feasibility_of(problem, {1, 2, 0.25}, {0, 0, 0}).violation.value, 0.75, 1e-15);
}

TEST(Feasibility, ComplementarityUsesTheBoundOfMultiplierSign) {
  const ShootingProblem problem =
      one_step_of(3, ConstraintKind::bounds, {0, -kOpenEnd, 1, 2, 3, 1});
  EXPECT_EQ(feasibility_of(problem, {1, 2, 1}, {0, 0, 7}).product.value,
            0);  // equal bounds: any sign
  EXPECT_NEAR(feasibility_of(problem, {0.5, 2, 1}, {2, 0, 0}).product.value, 2 * 1.5, 1e-15);
  EXPECT_NEAR(feasibility_of(problem, {0.5, 2, 1}, {-2, 0, 0}).product.value, 2 * 0.5, 1e-15);
  const Feasibility other = feasibility_of(problem, {0.5, 2, 1}, {0, 4, 0});
  EXPECT_NEAR(other.product.value, 4 * 1, 1e-15);
  EXPECT_NEAR(other.product.size, 4 * 3, 1e-15);
  EXPECT_EQ(other.negative.value, 0);
  // No lower bound exists that could push.
  const Feasibility wrong = feasibility_of(problem, {0.5, 2, 1}, {0, -4, 0});
  EXPECT_NEAR(wrong.negative.value, 4, 1e-15);
  EXPECT_EQ(wrong.product.value, 0);
  // Outside a bound, the violation covers the product.
  EXPECT_EQ(feasibility_of(problem, {2.5, 2, 1}, {2, 0, 0}).product.value, 0);
}

TEST(Feasibility, ViolatedSoftRowsHaveMultipliersAtLimit) {
  const ShootingProblem problem = one_step_of(2, ConstraintKind::bounds, {0, 0, 2, 2}, 5);
  const Feasibility above = feasibility_of(problem, {3, 1}, {5, 0});
  EXPECT_EQ(above.violation.value, 0);  // covered by the penalty
  EXPECT_NEAR(above.product.value, 0, 1e-15);
  EXPECT_NEAR(feasibility_of(problem, {3, 1}, {4, 0}).product.value, 1, 1e-15);
  EXPECT_NEAR(feasibility_of(problem, {-2, 1}, {-5, 0}).product.value, 0, 1e-15);
  EXPECT_NEAR(feasibility_of(problem, {-2, 1}, {-4.5, 0}).product.value, 2 * 0.5, 1e-15);
  EXPECT_NEAR(feasibility_of(problem, {1, 2}, {0, 5.5}).negative.value, 0.5, 1e-15);
  EXPECT_EQ(feasibility_of(problem, {1, 2}, {0, 5}).negative.value, 0);
}

TEST(Feasibility, ConeViolationIsDistanceFromTheCone) {
  const ShootingProblem problem = one_step_of(3, ConstraintKind::second_order_cone, {});
  EXPECT_EQ(feasibility_of(problem, {3, 4, 5}, {0, 0, 0}).violation.value, 0);
  EXPECT_NEAR(feasibility_of(problem, {3, 4, 3}, {0, 0, 0}).violation.value, std::sqrt(0.5) * 2,
              1e-14);
  EXPECT_NEAR(feasibility_of(problem, {3, 4, -12}, {0, 0, 0}).violation.value, 13, 1e-14);
  // On the boundary, the multiplier is orthogonal: νᵀg = 2 · 0.6 · 3 + 2 · 0.8 · 4 − 2 · 5 = 0.
  const Feasibility good = feasibility_of(problem, {3, 4, 5}, {1.2, 1.6, -2});
  EXPECT_NEAR(good.product.value, 0, 1e-14);
  EXPECT_EQ(good.negative.value, 0);
  const Feasibility inside = feasibility_of(problem, {3, 4, 6}, {1.2, 1.6, -2});
  EXPECT_NEAR(inside.product.value, 2, 1e-14);
  EXPECT_NEAR(inside.product.size, 22, 1e-13);
  // −ν = (−1.2, −1.6, 1) lies outside the cone by (2 − 1)/√2.
  EXPECT_NEAR(feasibility_of(problem, {3, 4, 5}, {1.2, 1.6, -1}).negative.value, std::sqrt(0.5),
              1e-14);
}

TEST(Feasibility, SoftConesPayTheirLimitTimesTheDistance) {
  const ShootingProblem problem = one_step_of(3, ConstraintKind::second_order_cone, {}, 2);
  // At (3, 4, 3), the distance is √2 along (0.6, 0.8, −1)/√2.
  const double s = 2 / std::sqrt(2.0);
  const Feasibility good = feasibility_of(problem, {3, 4, 3}, {0.6 * s, 0.8 * s, -s});
  EXPECT_EQ(good.violation.value, 0);
  EXPECT_NEAR(good.product.value, 0, 1e-14);
  EXPECT_EQ(good.negative.value, 0);
  EXPECT_NEAR(feasibility_of(problem, {3, 4, 3}, {0, 0, 0}).product.value, 2 * std::sqrt(2.0),
              1e-14);
  EXPECT_NEAR(feasibility_of(problem, {3, 4, 5}, {1.2, 1.6, -2}).negative.value, std::sqrt(8.0) - 2,
              1e-14);
}

TEST(Feasibility, PairViolationIsTheSmallerValue) {
  const ShootingProblem problem = one_step_of(4, ConstraintKind::complementarity, {});
  const Feasibility found = feasibility_of(problem, {0.5, 0, -0.125, 3}, {0, 7, 8, 0});
  EXPECT_NEAR(found.violation.value, 0.125, 1e-15);
  EXPECT_NEAR(found.violation.size, 3, 1e-15);
  EXPECT_EQ(found.product.value, 0);
  // The larger value of a pair carries no multiplier.
  EXPECT_NEAR(feasibility_of(problem, {0.5, 0, 0, 3}, {0.3, 0, 0, 0}).product.value, 0.15, 1e-15);
  EXPECT_NEAR(feasibility_of(problem, {0.5, 0, 0, 3}, {0, 0, 0, -0.2}).product.value, 0.6, 1e-15);
  // For equal values, the second counts as the larger.
  EXPECT_NEAR(feasibility_of(problem, {0.25, 0.25, 0, 0}, {2, 3, 0, 0}).product.value, 0.75, 1e-15);
}

TEST(Feasibility, ControlViolationUsesBothBounds) {
  const ShootingProblem problem =
      one_step_of(2, ConstraintKind::bounds, {-kOpenEnd, -kOpenEnd, kOpenEnd, kOpenEnd}, 0,
                  {-1, -kOpenEnd}, {3, 2});
  SolutionClaims claims(problem);
  claims.multipliers = numbers({0, 0});
  const auto measured = [&] { return measure_feasibility(problem, claims, numbers({0, 0})); };
  claims.trajectory.u(0) << -1.5, 0;
  EXPECT_NEAR(measured().violation.value, 0.5, 1e-15);
  EXPECT_EQ(measured().violation.entry, 0);
  EXPECT_EQ(constraint_of(measured().violation), -1);
  claims.trajectory.u(0) << 0, 2.25;
  EXPECT_NEAR(measured().violation.value, 0.25, 1e-15);
  EXPECT_EQ(measured().violation.entry, 1);
  claims.trajectory.u(0) << -0.5, 0;
  claims.lower_multipliers[0] << 4, 0;
  EXPECT_NEAR(measured().product.value, 4 * 0.5, 1e-15);
  claims.lower_multipliers[0] << 0, 0;
  claims.upper_multipliers[0] << 2, 0;
  EXPECT_NEAR(measured().product.value, 2 * 3.5, 1e-15);
  EXPECT_NEAR(measured().product.size, 2 * 3, 1e-15);
  claims.upper_multipliers[0] << 0, -0.5;
  EXPECT_NEAR(measured().negative.value, 0.5, 1e-15);
  claims.upper_multipliers[0] << 0, 0;
  claims.lower_multipliers[0] << 0, 1;
  EXPECT_EQ(measured().product.value, kOpenEnd);  // belongs to an absent bound
}

TEST(BeyondCone, IsDifferenceFromTheNearestPoint) {
  EXPECT_EQ(beyond_cone(numbers({3, 4, 5})), numbers({0, 0, 0}));
  EXPECT_EQ(beyond_cone(numbers({3, 4, -5})), numbers({3, 4, -5}));
  EXPECT_TRUE(beyond_cone(numbers({3, 4, 1})).isApprox(numbers({1.2, 1.6, -2}), 1e-15));
}

TEST(Worst, KeepsFirstMaximumAndPrefersNaN) {
  Worst worst;
  worst.meet(1, 0, 2, 3);
  worst.meet(1, 0, 4, 5);
  EXPECT_EQ(worst.knot, 2);
  worst.meet(std::nan(""), 0, 6, 7);
  worst.meet(9, 0, 8, 9);
  EXPECT_TRUE(std::isnan(worst.value));
  EXPECT_EQ(worst.knot, 6);
  EXPECT_EQ(worst.entry, 7);
}

// Share of a violation that controls could remove, by hand and for false claims.
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// One step x⁺ = x + u from the origin of the plane with |u| ≤ limit. It must end at the goal or,
/// if `cone`, in the cone |x_1 − g_1| ≤ x_2 − g_2.
ShootingProblem step_to(const Eigen::Vector2d& goal, double limit, bool cone = false) {
  const auto system = linear_system(Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity(),
                                    Eigen::Vector2d::Zero());
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->set_control_bounds({-limit, -limit}, {limit, limit});
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  end->add_constraint(
      make_constraint("end", state_residual(end->manifold()),
                      cone ? ConstraintKind::second_order_cone : ConstraintKind::bounds));
  std::vector<double> constraint{goal[0], goal[1]};
  if (!cone) constraint.insert(constraint.end(), 4, 0.0);
  constraint.push_back(1);
  std::vector<Phase> phases;
  phases.push_back({.name = "go", .model = running, .dt = {1}, .cost_scale = {1}});
  return ShootingProblem(
      {0, 0}, std::move(phases),
      {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}, .parameters = constraint});
}

double share(const ShootingProblem& problem, const Eigen::Vector2d& u,
             const Eigen::Vector2d& value) {
  Trajectory trajectory = problem.create_trajectory();
  trajectory.u(0) = u;
  trajectory.x(1) = u;
  const auto derivatives = node_derivatives(problem, trajectory, Eigen::MatrixXd::Zero(2, 1));
  Eigen::VectorXd values(problem.constraint_rows());
  values.tail(2) = value;
  return attainable_share(problem, trajectory, derivatives, values);
}

TEST(AttainableShare, MatchesAStepByHand) {
  // d = (−3, −4) with direction (−0.6, −0.8): both controls can move up by 1.
  EXPECT_NEAR(share(step_to({3, 4}, 1), {0, 0}, {-3, -4}), (0.6 + 0.8) / 5, 1e-14);
  // At their bounds, controls cannot move.
  EXPECT_EQ(share(step_to({3, 4}, 1), {1, 1}, {-2, -3}), 0);
  // Without bounds, a control can move by its largest magnitude (at least 1).
  EXPECT_NEAR(share(step_to({3, 4}, kInfinity), {0, 5}, {-3, 1}), 5 * (3 + 1) / 10.0, 1e-14);
}

TEST(AttainableShare, ConeShareIsAlongItsDistance) {
  // The point of the cone nearest to (3, −1) is (1, 1): d = (2, −2).
  EXPECT_NEAR(share(step_to({-3, 1}, 1, true), {0, 0}, {3, -1}), (2 + 2) / 8.0, 1e-14);
  // Below the polar cone, the tip is nearest.
  EXPECT_NEAR(share(step_to({-1, 3}, 1, true), {0, 0}, {1, -3}), (1 + 3) / 10.0, 1e-14);
}

/// Certificate of a motion that is claimed to be infeasible.
Certificate of_infeasible(const ShootingProblem& problem, const Eigen::Vector2d& u,
                          const Eigen::Vector2d& next) {
  SolutionClaims claims(problem);
  claims.times = problem.times();
  claims.status = "infeasible";
  claims.trajectory.u(0) = u;
  claims.trajectory.x(1) = next;
  claims.cost = claims.stationarity = claims.complementarity = 0;
  claims.gap = (next - u).lpNorm<Eigen::Infinity>();
  claims.constraint = (next - Eigen::Vector2d(3, 4)).lpNorm<Eigen::Infinity>();
  return certify(problem, claims);
}

bool least(const Certificate& certificate) {
  for (const Check& check : certificate.checks)
    if (check.name == "least violation") return check.holds;
  ADD_FAILURE() << "there is no such check";
  return false;
}

TEST(InfeasibleIs, OnlyWhatNoControlCanImprove) {
  const ShootingProblem problem = step_to({3, 4}, 1);
  EXPECT_TRUE(least(of_infeasible(problem, {1, 1}, {1, 1})));
  EXPECT_FALSE(least(of_infeasible(problem, {1, 0.5}, {1, 0.5})));
  EXPECT_FALSE(least(of_infeasible(problem, {1, 1}, {2, 1})));  // not the end of the simulated step
}

/// One step x⁺ = x + u from the origin with rows on its control and a soft row at the end.
double share_of_rows(ConstraintKind kind, const std::vector<double>& bounds,
                     const Eigen::VectorXd& values) {
  const int n = static_cast<int>(values.size());
  const auto system = linear_system(Eigen::MatrixXd::Identity(n, n),
                                    Eigen::MatrixXd::Identity(n, n), Eigen::VectorXd::Zero(n));
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->add_constraint(make_constraint("rows", control_residual(n, n), kind));
  running->set_control_bounds(std::vector<double>(n, -4), std::vector<double>(n, 8));
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  end->add_constraint(make_constraint("soft", state_residual(end->manifold()),
                                      ConstraintKind::bounds, 1, Softness::l1));
  std::vector<double> parameters(n, 0.0), last(3 * n, 0.0);
  parameters.insert(parameters.end(), bounds.begin(), bounds.end());
  parameters.push_back(1);
  last.insert(last.end(), {1, 7});
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "go", .model = running, .dt = {1}, .cost_scale = {1}, .parameters = parameters});
  const ShootingProblem problem(
      std::vector<double>(n, 0.0), std::move(phases),
      {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}, .parameters = last});
  const Trajectory trajectory = problem.create_trajectory();
  const auto derivatives = node_derivatives(problem, trajectory, Eigen::MatrixXd::Zero(n, 1));
  Eigen::VectorXd all(2 * n);
  all << values, Eigen::VectorXd::Constant(n, 9);
  return attainable_share(problem, trajectory, derivatives, all);
}

// Each control can decrease to −4 where a row is above, and increase to 8 where it is below.
TEST(AttainableShare, CountsViolatedHardRows) {
  const std::vector<double> bounds = {-1, -1, -1, 1, 2, 3};
  EXPECT_NEAR(share_of_rows(ConstraintKind::bounds, bounds, Eigen::Vector3d(0.5, 2, 5)),
              2 * 4 / 4.0, 1e-14);
  EXPECT_NEAR(share_of_rows(ConstraintKind::bounds, bounds, Eigen::Vector3d(-4, 2.5, 1)),
              (3 * 8 + 0.5 * 4) / 9.25, 1e-14);
}

TEST(AttainableShare, PairShareIsAlongTheSmallerValue) {
  EXPECT_NEAR(share_of_rows(ConstraintKind::complementarity, {}, Eigen::Vector4d(3, 1, -2, 0.5)),
              (1 * 4 + 2 * 8) / 5.0, 1e-14);
  EXPECT_NEAR(share_of_rows(ConstraintKind::complementarity, {}, Eigen::Vector4d(0.5, 0.5, 0, 7)),
              4 * 0.5 / 0.25, 1e-14);
}

SecondOrder model_at(const ShootingProblem& problem, const Eigen::Vector2d& u) {
  Trajectory trajectory = problem.create_trajectory();
  trajectory.u(0) = u;
  trajectory.x(1) = u;
  return violation_model(problem, trajectory, Eigen::MatrixXd::Zero(2, 1));
}

TEST(ViolationModel, PromisesNothingAtTheLeastViolation) {
  const SecondOrder least = model_at(step_to({3, 4}, 1), {1, 1});
  EXPECT_NE(least.curvature, Curvature::negative);
  EXPECT_EQ(least.share(), 0);
  // A Newton step goes to the bounds or to the goal.
  EXPECT_GT(model_at(step_to({3, 4}, 1), {0, 0.5}).share(), 0.1);
  EXPECT_NEAR(model_at(step_to({3, 4}, kInfinity), {1, 1}).gain, (2 * 2 + 3 * 3) / 2.0, 1e-12);
}

/// The same step x⁺ = x + unit u without bounds, from the origin to (3, 4).
TEST(ViolationModel, IsIndependentOfControlUnits) {
  for (const double unit : {1e-9, 1e-3, 1.0}) {
    const auto system = linear_system(Eigen::Matrix2d::Identity(),
                                      unit * Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero());
    auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
    auto end = std::make_shared<KnotModel>(system, Integrator::none);
    end->add_constraint(
        make_constraint("end", state_residual(end->manifold()), ConstraintKind::bounds));
    std::vector<Phase> phases;
    phases.push_back({.name = "go", .model = running, .dt = {1}, .cost_scale = {1}});
    const ShootingProblem problem({0, 0}, std::move(phases),
                                  {.name = "end",
                                   .model = end,
                                   .dt = {0},
                                   .cost_scale = {1},
                                   .parameters = {3, 4, 0, 0, 0, 0, 1}});
    EXPECT_FALSE(least(of_infeasible(problem, {0, 0}, {0, 0}))) << unit;
  }
}

}  // namespace
}  // namespace conddp
