// Constraints whose multipliers follow from the optimality conditions by hand.
#include "analysis/certificate/certificate.hpp"

#include <gtest/gtest.h>

#include "support/one_step.hpp"

namespace conddp {
namespace {

using testing::claims_of;
using testing::one_step;

std::string failures(const Certificate& certificate) {
  std::string names;
  for (const Check& check : certificate.checks)
    if (!check.holds) names += "[" + check.name + "]";
  return names;
}

Eigen::VectorXd vector(std::initializer_list<double> values) {
  return Eigen::Map<const Eigen::VectorXd>(values.begin(),
                                           static_cast<Eigen::Index>(values.size()));
}

constexpr double kFree = std::numeric_limits<double>::infinity();

TEST(CertificateOfConstraints, HoldsAtAnEqualityWithEitherSign) {
  for (const double goal : {1.0, -1.0}) {
    const ShootingProblem problem = one_step({0}, ConstraintKind::bounds, {goal, goal});
    EXPECT_EQ(failures(certify(problem, claims_of(problem, vector({goal}), vector({-goal}), 0.5))),
              "");
  }
}

TEST(CertificateOfConstraints, SignsIdentifyTheBound) {
  const ShootingProblem above = one_step({0}, ConstraintKind::bounds, {1, kFree});
  SolutionClaims claims = claims_of(above, vector({1}), vector({-1}), 0.5);
  EXPECT_EQ(failures(certify(above, claims)), "");
  claims.multipliers[0] = 1;
  const std::string found = failures(certify(above, claims));
  EXPECT_NE(found.find("[signs of multipliers]"), std::string::npos) << found;
  EXPECT_NE(found.find("[co-states]"), std::string::npos) << found;
}

TEST(CertificateOfConstraints, FindsViolationsAndUnmetBounds) {
  const ShootingProblem problem = one_step({0}, ConstraintKind::bounds, {1.5, kFree});
  // Stationary, but half a unit short of the constraint.
  const std::string short_of =
      failures(certify(problem, claims_of(problem, vector({1}), vector({-1}), 0.5)));
  EXPECT_NE(short_of.find("[constraint violation]"), std::string::npos) << short_of;
  const ShootingProblem loose = one_step({0}, ConstraintKind::bounds, {0.5, kFree});
  const std::string beyond =
      failures(certify(loose, claims_of(loose, vector({1}), vector({-1}), 0.5)));
  EXPECT_NE(beyond.find("[complementarity]"), std::string::npos) << beyond;
}

TEST(CertificateOfConstraints, SupportsSecondOrderCones) {
  const ShootingProblem problem = one_step({1, 0}, ConstraintKind::second_order_cone, {});
  // (0.5, 0.5) is the point of the cone |v| ≤ t nearest to (1, 0).
  const SolutionClaims good = claims_of(problem, vector({0.5, 0.5}), vector({0.5, -0.5}), 0.25);
  EXPECT_EQ(failures(certify(problem, good)), "");
  SolutionClaims wrong = good;
  wrong.multipliers = -wrong.multipliers;
  EXPECT_NE(failures(certify(problem, wrong)).find("[signs of multipliers]"), std::string::npos);
  // (1, 0) lies outside, 1/√2 from the cone.
  SolutionClaims outside = claims_of(problem, vector({1, 0}), vector({0, 0}), 0);
  outside.converged = false;
  outside.status = "max_iterations";
  outside.constraint = std::sqrt(0.5);
  EXPECT_EQ(failures(certify(problem, outside)), "");
  outside.constraint = 1;
  EXPECT_EQ(failures(certify(problem, outside)), "[constraint violation]");
}

TEST(CertificateOfConstraints, ConvergedNeedsComplementarity) {
  // Stationary and feasible; the claimed multiplier belongs to a bound half a unit away.
  const ShootingProblem problem = one_step({0}, ConstraintKind::bounds, {0.5, kFree});
  SolutionClaims claims = claims_of(problem, vector({1}), vector({-1}), 0.5);
  claims.complementarity = 0.5;
  EXPECT_EQ(failures(certify(problem, claims)), "[status]");
  claims.converged = false;
  claims.status = "max_iterations";
  EXPECT_EQ(failures(certify(problem, claims)), "");
}

/// A step to 1 − 2e-7 instead of the required 1: feasible within tolerance, but not optimal.
TEST(CertificateOfConstraints, CostSettledNeedsFeasibilityAndItsOption) {
  constexpr double kShort = 2e-7;
  const ShootingProblem problem = one_step({0}, ConstraintKind::bounds, {1, 1});
  const double u = 1 - kShort;
  SolutionClaims claims = claims_of(problem, vector({u}), vector({0}), 0.5 * u * u);
  claims.stationarity = u;
  claims.constraint = kShort;
  claims.converged = false;
  claims.status = "cost_settled";
  claims.tolerances.cost_decrease = 1e-4;
  EXPECT_EQ(failures(certify(problem, claims)), "");
  SolutionClaims unasked = claims;
  unasked.tolerances.cost_decrease = 0;
  EXPECT_EQ(failures(certify(problem, unasked)), "[status]");
  claims.tolerances.constraint = kShort / 2;
  EXPECT_EQ(failures(certify(problem, claims)), "[status]");
}

TEST(CertificateOfConstraints, SoftRowMultipliersStayWithinTheirLimit) {
  const auto found = [](double weight) {
    const ShootingProblem problem = one_step({0}, ConstraintKind::bounds, {1, kFree}, weight);
    SolutionClaims claims = claims_of(problem, vector({1}), vector({-1}), 0.5);
    claims.cost_by_name.emplace_back("terminal/end", 0);
    return failures(certify(problem, claims));
  };
  EXPECT_EQ(found(1.1), "");
  EXPECT_EQ(found(0.9), "[signs of multipliers]");
}

TEST(CertificateOfConstraints, SoftConeMultipliersStayWithinTheirLimit) {
  // At (0.5, 0.5) on the cone, the multiplier of a hard constraint has norm 1/√2.
  const auto found = [](double weight) {
    const ShootingProblem problem = one_step({1, 0}, ConstraintKind::second_order_cone, {}, weight);
    SolutionClaims claims = claims_of(problem, vector({0.5, 0.5}), vector({0.5, -0.5}), 0.25);
    claims.cost_by_name.emplace_back("terminal/end", 0);
    return failures(certify(problem, claims));
  };
  EXPECT_EQ(found(0.8), "");
  EXPECT_EQ(found(0.7), "[signs of multipliers]");
}

/// A step of two coordinates that ends inside the hard rows and beyond the soft rows.
TEST(CertificateOfConstraints, SoftConstraintsCostTheirDistance) {
  for (const Softness softness : {Softness::l1, Softness::l2}) {
    const auto system =
        linear_system(Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity(), vector({0, 0}));
    auto end = std::make_shared<KnotModel>(system, Integrator::none);
    const auto state = state_residual(end->manifold());
    end->add_constraint(make_constraint("hard", state, ConstraintKind::bounds));
    end->add_constraint(make_constraint("soft", state, ConstraintKind::bounds, 1, softness));
    std::vector<Phase> phases;
    phases.push_back({.name = "go",
                      .model = std::make_shared<KnotModel>(system, Integrator::discrete),
                      .dt = {1},
                      .cost_scale = {1}});
    const ShootingProblem problem({0, 0}, std::move(phases),
                                  {.name = "end",
                                   .model = end,
                                   .dt = {0},
                                   .cost_scale = {1},
                                   .parameters = {0, 0, -9, -9, 9, 9, 1,  //
                                                  0, 0, -9, -9, 2, 1, 1, 3}});
    // 1 and 3 units beyond the upper bounds, with weight 3.
    SolutionClaims claims = claims_of(problem, vector({3, 4}), vector({0, 0}), 0);
    claims.multipliers = Eigen::VectorXd::Zero(problem.constraint_rows());
    claims.cost = softness == Softness::l1 ? 3 * (1 + 3) : 0.5 * 3 * (1 + 9);
    claims.cost_by_name = {{"terminal/soft", claims.cost}};
    const std::string found = failures(certify(problem, claims));
    EXPECT_EQ(found.find("[cost"), std::string::npos) << found;
    claims.cost_by_name[0].first = "soft";
    EXPECT_NE(failures(certify(problem, claims)).find("[cost terminal/soft]"), std::string::npos);
  }
}

/// Rounding may change a multiplier of 10⁶ by 10⁻⁴. Figures therefore agree even if they differ by
/// far more than the convergence tolerance.
TEST(CertificateOfConstraints, ConvergedNeedsTheComputedComplementarity) {
  constexpr double kWeight = 100, kWay = 1e4, kShort = 1e-11;
  const ShootingProblem problem =
      one_step({0}, ConstraintKind::bounds, {kWay - kShort, kFree}, 0, kWeight);
  const SolutionClaims claims =
      claims_of(problem, vector({kWay}), vector({-kWeight * kWay}), 0.5 * kWeight * kWay * kWay);
  ASSERT_GT(kWeight * kWay * kShort, claims.tolerances.complementarity);
  EXPECT_EQ(failures(certify(problem, claims)), "[status]");
}

// Only a diverged answer may omit figures. Its gradient is not checked where rounding exceeds it.
TEST(Certificate, OnlyDivergedAnswersMayOmitFigures) {
  const ShootingProblem problem = one_step({0}, ConstraintKind::bounds, {1, 1});
  const SolutionClaims good = claims_of(problem, vector({1}), vector({-1}), 0.5);
  const std::pair<double SolutionClaims::*, std::string> figures[] = {
      {&SolutionClaims::cost, "[cost]"},
      {&SolutionClaims::gap, "[gap]"},
      {&SolutionClaims::constraint, "[constraint violation]"},
      {&SolutionClaims::complementarity, "[complementarity]"},
      {&SolutionClaims::stationarity, "[stationarity]"}};
  for (const auto& [figure, name] : figures) {
    SolutionClaims claims = good;
    claims.converged = false;
    claims.*figure = SolutionClaims::kOpen;
    claims.status = "max_iterations";
    if (name == "[cost]") claims.stationarity = claims.tolerances.stationarity;  // not converged
    const std::string found = failures(certify(problem, claims));
    EXPECT_NE(found.find(name), std::string::npos) << found;
    claims.status = "diverged";
    EXPECT_EQ(failures(certify(problem, claims)).find(name), std::string::npos) << name;
  }
  SolutionClaims wild = good;
  wild.converged = false;
  wild.status = "diverged";
  for (const double stationarity : {1e15, 1e17}) {
    wild.stationarity = stationarity;
    EXPECT_EQ(failures(certify(problem, wild)), stationarity < 1e16 ? "[stationarity]" : "");
  }
}

TEST(Certificate, ComparesTimesAndInitialStateByEntry) {
  const ShootingProblem problem = one_step({0, 0}, ConstraintKind::bounds, {1, 1, 1, 1});
  const SolutionClaims good = claims_of(problem, vector({1, 1}), vector({-1, -1}), 1);
  EXPECT_EQ(failures(certify(problem, good)), "");
  for (const int node : {0, 1}) {
    SolutionClaims claims = good;
    claims.times[node] += 1e-11;
    EXPECT_EQ(failures(certify(problem, claims)), "[times]") << node;
    claims.times[node] = good.times[node] + 1e-13;
    EXPECT_EQ(failures(certify(problem, claims)), "") << node;
  }
  for (const int entry : {0, 1}) {
    SolutionClaims claims = good;
    claims.trajectory.x(0)[entry] = 1e-6;
    const std::string found = failures(certify(problem, claims));
    EXPECT_NE(found.find("[initial state]"), std::string::npos) << found;
  }
}

/// x⁺ = x + (u, 0): no control determines the second costate.
TEST(CertificateOfCostates, ConvergedNeedsCostatesOfOtherGains) {
  const auto system = linear_system(Eigen::MatrixXd::Identity(2, 2), Eigen::Vector2d(1, 0),
                                    Eigen::VectorXd::Zero(2));
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->add_cost("effort", control_residual(2, 1), {});
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "go", .model = running, .dt = {1}, .cost_scale = {1}, .parameters = {0, 1}});
  const ShootingProblem problem({0, 0}, std::move(phases),
                                {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}});
  SolutionClaims claims(problem);
  claims.times = problem.times();
  claims.converged = true;
  claims.status = "converged";
  claims.cost = claims.stationarity = claims.gap = claims.constraint = claims.complementarity = 0;
  claims.cost_by_name = {{"effort", 0}};
  EXPECT_EQ(failures(certify(problem, claims)), "");
  // A consistent claim about a costate that only its own equation contradicts.
  claims.costates(1, 1) = claims.costates(1, 0) = 5;
  claims.state_gradient(1, 1) = -5;
  EXPECT_EQ(failures(certify(problem, claims)), "[status]");
}

/// One step u with cost ½ (u − 1)² and bound u ≤ ½: the multiplier of the upper bound is ½.
TEST(CertificateOfBounds, MultipliersHaveTheirSign) {
  const auto system = linear_system(Eigen::MatrixXd::Identity(1, 1),
                                    Eigen::MatrixXd::Identity(1, 1), Eigen::VectorXd::Zero(1));
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->add_cost("effort", control_residual(1, 1), {});
  running->set_control_bounds({-kFree}, {0.5});
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "go", .model = running, .dt = {1}, .cost_scale = {1}, .parameters = {1, 1}});
  const ShootingProblem problem({0}, std::move(phases),
                                {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}});
  SolutionClaims claims = claims_of(problem, vector({0.5}), vector({0}), 0.125);
  claims.multipliers.resize(0);
  claims.upper_multipliers[0] = vector({0.5});
  EXPECT_EQ(failures(certify(problem, claims)), "");
  // The sum of both multipliers balances the gradient, but neither bound pulls.
  claims.upper_multipliers[0] = vector({0});
  claims.lower_multipliers[0] = vector({-0.5});
  const std::string found = failures(certify(problem, claims));
  EXPECT_NE(found.find("[signs of multipliers]"), std::string::npos) << found;
}

/// Claims for a step u with cost ½ ε (u − 1)² + ½ ε (x + u)², whose optimum is ½.
std::string failures_of_gain(double u, double epsilon) {
  const auto system = linear_system(Eigen::MatrixXd::Identity(1, 1),
                                    Eigen::MatrixXd::Identity(1, 1), Eigen::VectorXd::Zero(1));
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->add_cost("effort", control_residual(1, 1), {});
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  end->add_cost("rest", state_residual(end->manifold()), {});
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "go", .model = running, .dt = {1}, .cost_scale = {1}, .parameters = {1, epsilon}});
  const ShootingProblem problem(
      {0}, std::move(phases),
      {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}, .parameters = {0, epsilon}});
  const double effort = 0.5 * epsilon * (u - 1) * (u - 1), rest = 0.5 * epsilon * u * u;
  SolutionClaims claims = claims_of(problem, vector({u}), vector({epsilon * u}), effort + rest);
  claims.multipliers.resize(0);
  claims.cost_by_name = {{"effort", effort}, {"terminal/rest", rest}};
  claims.stationarity = std::abs(epsilon * (2 * u - 1));
  claims.tolerances.stationarity = 1e-5;
  return failures(certify(problem, claims));
}

// A Newton step reduces the cost ε (¼ + (u − ½)²) by ε (u − ½)².
TEST(Certificate, OptimumLeavesAlmostNoCostToGain) {
  EXPECT_EQ(failures_of_gain(0.5015, 1e-5), "");
  EXPECT_EQ(failures_of_gain(0.5017, 1e-5), "[status]");
  EXPECT_EQ(failures_of_gain(0.99, 1e-5), "[status]");
}

// Tolerances assume costs of ordinary magnitude.
TEST(Certificate, AcceptsOptimaOfSmallAndLargeCosts) {
  for (const double epsilon : {0x1p-100, 0x1p-20, 0x1p20, 0x1p100}) {
    EXPECT_EQ(failures_of_gain(0.5, epsilon), "") << epsilon;
    EXPECT_EQ(failures_of_gain(0.5 + 4e-6, epsilon), "") << epsilon;
    EXPECT_EQ(failures_of_gain(0.5 + 1e-3, epsilon), "[status]") << epsilon;
  }
}

TEST(Certificate, DoubtsOnlyOptimalityOfFeasibleAnswers) {
  Certificate certificate;
  EXPECT_FALSE(certificate.doubts_optimality_alone());
  certificate.checks = {{.name = kStatusCheck, .holds = false}, {.name = "gap"}};
  EXPECT_FALSE(certificate.doubts_optimality_alone());
  certificate.optimality_in_doubt = true;
  EXPECT_TRUE(certificate.doubts_optimality_alone());
  certificate.checks.push_back({.name = kFeedforwardCheck, .holds = false});
  EXPECT_TRUE(certificate.doubts_optimality_alone());
  certificate.checks[1].holds = false;
  EXPECT_FALSE(certificate.doubts_optimality_alone());
}

}  // namespace
}  // namespace conddp
