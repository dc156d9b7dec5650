// Problems with states, controls, and rows in other units.
#include "solvers/strategies/problem_units.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_horizon.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// Exact parking at a goal with bounded speed and turning rate.
ShootingProblem parking() {
  const ShootingProblem free = testing::unicycle_parking(0.6);
  return testing::with_constraints(free, {testing::goal_constraint(free, {0, 0, 0})});
}

/// The same with the norm of two states at node 2, and a cone of a state and both controls at node
/// 3.
ShootingProblem parking_in_sets() {
  const ShootingProblem free = testing::unicycle_parking(0.6);
  Eigen::MatrixXd states = Eigen::MatrixXd::Zero(2, 5), cone = Eigen::MatrixXd::Zero(3, 5);
  states << 1, 2, 0, 0, 0, 0, 1, -1, 0, 0;
  cone << 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 3;
  testing::Added norm = testing::affine_rows(states, free, 2, 2, 0, 0);
  norm.name = "norm";
  norm.kind = ConstraintKind::norm;
  norm.lower = {0.1};
  norm.upper = {2};
  testing::Added within = testing::affine_rows(cone, free, 3, 3, 0, 0);
  within.name = "cone";
  within.kind = ConstraintKind::second_order_cone;
  within.slope = 0.7;
  within.lower = within.upper = {};
  return testing::with_constraints(
      free, {testing::goal_constraint(free, {0, 0, 0}), std::move(norm), std::move(within)});
}

ProblemUnits units(const ShootingProblem& problem, std::vector<double> state,
                   std::vector<double> control) {
  ProblemUnits units{.state = std::move(state)};
  for (int k = 0; k <= problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    std::vector<double> rows;
    for (int i = 0; i < model.constraint_rows(); ++i) rows.push_back(std::exp2(3 * i - 5));
    units.models[&model] = {model.nu() > 0 ? control : std::vector<double>(), rows};
  }
  return units;
}

/// Far from all stationary points.
Trajectory point(const ShootingProblem& problem) {
  Trajectory t = testing::constant_controls(problem, 0.1);
  for (int k = 1; k <= problem.knots(); ++k)
    t.x(k) += Eigen::Vector3d(0.03 * k, std::sin(0.7 * k), -0.02 * k);
  return t;
}

Trajectory in_units(Trajectory t, const ProblemUnits& units, const std::vector<double>& control) {
  for (int k = 0; k <= t.knots(); ++k)
    for (int i = 0; i < t.nx(); ++i) t.x(k)[i] /= units.state[i];
  for (int k = 0; k < t.knots(); ++k)
    for (int i = 0; i < t.nu(k); ++i) t.u(k)[i] /= control[i];
  return t;
}

/// Powers of two change no digit.
TEST(ProblemUnits, DerivativesFollowTheChainRule) {
  const ShootingProblem own = parking_in_sets();
  const std::vector<double> control{0.25, 64};
  const ProblemUnits other = units(own, {1024, 0.125, 4}, control);
  const ShootingProblem given = in_units(own, other);
  const Trajectory t = point(own), in_given = in_units(t, other, control);
  Linearization a(own), b(given);
  const Eigen::MatrixXd costates = Eigen::MatrixXd::Constant(3, own.knots() + 1, 0.5);
  Eigen::MatrixXd costates_given = costates;
  for (int i = 0; i < 3; ++i) costates_given.row(i) *= other.state[i];
  for (const bool exact : {false, true}) {
    Evaluator of_own(own), of_given(given);
    of_own.differentiate(t, a);
    of_given.differentiate(in_given, b);
    if (exact) {
      of_own.lagrangian_hessian(t, costates, a);
      of_given.lagrangian_hessian(in_given, costates_given, b);
    }
    EXPECT_EQ(a.total_cost(), b.total_cost());
    for (int k = 0; k <= own.knots(); ++k) {
      const auto& rows = other.at(own, k).row_factors;
      std::vector<double> unit = other.state;
      if (own.nu(k) > 0) unit.insert(unit.end(), control.begin(), control.end());
      const Eigen::Map<const Eigen::VectorXd> z(unit.data(), unit.size());
      const Eigen::Map<const Eigen::VectorXd> factor(rows.data(), rows.size());
      const KnotLinearization &of = a.knots[k], &to = b.knots[k];
      EXPECT_EQ(to.gradient, of.gradient.cwiseProduct(z));
      const Eigen::MatrixXd hessian = z.asDiagonal() * of.hessian() * z.asDiagonal();
      EXPECT_LE((to.hessian() - hessian).norm(), 1e-13 * hessian.norm()) << exact;
      EXPECT_EQ(to.C, Eigen::MatrixXd(factor.asDiagonal() * of.C * z.asDiagonal()));
      EXPECT_EQ(b.constraint.segment(given.constraint_offset(k), rows.size()),
                a.constraint.segment(own.constraint_offset(k), rows.size()).cwiseProduct(factor));
      if (k == own.knots()) break;
      EXPECT_EQ(to.F,
                Eigen::MatrixXd(z.head(3).cwiseInverse().asDiagonal() * of.F * z.asDiagonal()));
      EXPECT_EQ(b.gap.col(k), a.gap.col(k).cwiseQuotient(z.head(3)));
    }
  }
}

/// A problem in unusual units is solved like in usual ones, and its answer keeps its units.
TEST(ProblemUnits, AnswersAgreeInOtherUnits) {
  const ShootingProblem own = parking();
  Trajectory guess = testing::constant_controls(own, 0.01);
  for (int k = 1; k <= own.knots(); ++k) guess.x(k) += Eigen::Vector3d(0.1, 0.5, 0.1);
  ASSERT_FALSE(units_of(own, guess));
  const std::vector<double> control{0x1p-8, 0x1p8};
  const ProblemUnits other = units(own, {0x1p-16, 0x1p-15, 0x1p-20}, control);
  const ShootingProblem given = in_units(own, other);
  for (const char* solver : {"altro", "proxddp", "ipopt"}) {
    SolverOptions options;
    options.tolerances.stationarity = 1e-3;  // above the rounding of each unit
    const SolveResult usual = solve(own, solver, options, guess);
    ASSERT_EQ(usual.status, SolveStatus::converged) << solver;
    const SolveResult result = solve(given, solver, options, in_units(guess, other, control));
    EXPECT_EQ(result.status, SolveStatus::converged) << solver << result.message;
    EXPECT_NEAR(result.cost, usual.cost, 1e-6 * usual.cost) << solver;
    const Trajectory expected = in_units(usual.trajectory, other, control);
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(result.trajectory.x(7)[i], expected.x(7)[i], 1e-4 / other.state[i]) << solver;
    EXPECT_NEAR(result.trajectory.u(3)[1], expected.u(3)[1], 1e-4 / control[1]) << solver;
    const int terminal = own.constraint_offset(own.knots());
    const double factor = other.at(own, own.knots()).row_factors[0];
    EXPECT_NEAR(result.constraint_multipliers[terminal] * factor,
                usual.constraint_multipliers[terminal],
                1e-3 * std::abs(usual.constraint_multipliers[terminal]))
        << solver;
    EXPECT_LE(result.residuals.constraint, 1e-6) << solver;
  }
}

TEST(ProblemUnits, ComeFromBoundsGuessAndRows) {
  const ShootingProblem own = parking();
  const std::vector<double> control{0x1p-13, 0x1p13};
  const ProblemUnits other = units(own, {0x1p-16, 0x1p-15, 1}, control);
  const ShootingProblem given = in_units(own, other);
  Trajectory guess = in_units(point(own), other, control);
  const auto found = units_of(given, guess);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->far_apart);
  EXPECT_GE(found->state[0], 0x1p8);
  EXPECT_GE(found->state[1], 0x1p8);
  const auto& of_first = found->at(given, 0);
  EXPECT_EQ(of_first.control[0], std::exp2(std::round(std::log2(0.6 / control[0]))));
  EXPECT_EQ(of_first.control[1], std::exp2(std::round(std::log2(0.6 / control[1]))));
  guess.u(0)[0] = std::nan("");
  EXPECT_FALSE(units_of(given, guess)) << "nothing is known of such a guess";
}

}  // namespace
}  // namespace conddp
