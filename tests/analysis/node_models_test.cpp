#include "analysis/derivatives/node_models.hpp"

#include <functional>

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "support/constrained_problems.hpp"
#include "support/random_robot.hpp"
#include "support/small_problems.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

ShootingProblem cartpole_with_goal() {
  const ShootingProblem free = testing::cartpole_swing_up();
  return testing::with_constraints(
      free, {testing::goal_constraint(free, std::vector<double>(free.nx(), 0.0))});
}

/// A trajectory near the constant one, with open gaps.
struct Point {
  explicit Point(const ShootingProblem& of) : problem(of), t(of.create_trajectory()) {
    std::srand(5);
    for (int k = 0; k <= problem.knots(); ++k) {
      const Eigen::VectorXd move = 0.3 * Eigen::VectorXd::Random(problem.ndx());
      problem.manifold().integrate(t.x(k).data(), move.data(), t.x(k).data());
      if (k < problem.knots()) t.u(k).setRandom();
    }
    Evaluator(problem).differentiate(t, analytic);
  }

  NodeModels models() const { return confirmed_models(problem, t, analytic.gap, analytic); }

  const ShootingProblem& problem;
  Trajectory t;
  Linearization analytic{problem};
};

double difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.size() == 0 ? 0 : (a - b).cwiseAbs().maxCoeff() / std::max(1.0, a.cwiseAbs().maxCoeff());
}

void expect_derivatives_of_dual_numbers(const Point& at, const NodeModels& models) {
  const auto reference = node_derivatives(at.problem, at.t, at.analytic.gap);
  ASSERT_EQ(models.derivatives.size(), reference.size());
  for (std::size_t k = 0; k < reference.size(); ++k) {
    EXPECT_LT(difference(reference[k].cost, models.derivatives[k].cost), 1e-12) << k;
    EXPECT_LT(difference(reference[k].constraint, models.derivatives[k].constraint), 1e-12) << k;
    EXPECT_LT(difference(reference[k].step, models.derivatives[k].step), 1e-12) << k;
  }
}

/// On flat and curved spaces, with open gaps and constraints.
TEST(NodeModels, KeepAnalyticDerivativesThatAgreeWithDualNumbers) {
  const ShootingProblem problems[] = {
      testing::cartpole_swing_up(), cartpole_with_goal(), testing::quadrotor_move(),
      testing::cartpole_swing_up(testing::kFree, Integrator::semi_implicit_euler)};
  for (const ShootingProblem& problem : problems) {
    const Point at(problem);
    const NodeModels models = node_models(problem, at.t, at.analytic.gap);
    EXPECT_EQ(models.by_dual_numbers, 0);
    expect_derivatives_of_dual_numbers(at, models);
    const auto hessians = gauss_newton_hessians(problem, at.t);
    for (std::size_t k = 0; k < hessians.size(); ++k)
      EXPECT_EQ(models.hessians[k], hessians[k]) << k;
  }
}

/// Perturbs every entry of every matrix by as little as 10⁻¹⁰ of the largest neighboring entry.
TEST(NodeModels, UseDualNumbersInsteadOfWrongAnalyticDerivatives) {
  const ShootingProblem problem = cartpole_with_goal();
  const int N = problem.knots(), k = 3;
  const std::function<Eigen::Map<Eigen::VectorXd>(Linearization&)> parts[] = {
      [&](Linearization& l) {
        return Eigen::Map<Eigen::VectorXd>(l.knots[k].F.data(), l.knots[k].F.size());
      },
      [&](Linearization& l) {
        return Eigen::Map<Eigen::VectorXd>(l.knots[k].gradient.data(), l.knots[k].gradient.size());
      },
      [&](Linearization& l) {
        return Eigen::Map<Eigen::VectorXd>(l.knots[N].gradient.data(), l.knots[N].gradient.size());
      },
      [&](Linearization& l) {
        return Eigen::Map<Eigen::VectorXd>(l.knots[N].C.data(), l.knots[N].C.size());
      }};
  for (const auto& part : parts) {
    Point at(problem);
    const Eigen::VectorXd right = part(at.analytic);
    ASSERT_GT(right.size(), 0);
    for (Eigen::Index i = 0; i < right.size(); ++i) {
      part(at.analytic)[i] += 1e-10 * std::max(1.0, right.cwiseAbs().maxCoeff());
      EXPECT_EQ(at.models().by_dual_numbers, 1) << i;
      part(at.analytic)[i] = right[i];
    }
    part(at.analytic)[0] = std::numeric_limits<double>::quiet_NaN();
    const NodeModels models = at.models();
    EXPECT_EQ(models.by_dual_numbers, 1);
    expect_derivatives_of_dual_numbers(at, models);
  }
}

/// Two entries that cancel along the all-ones direction do not cancel along a random one.
TEST(NodeModels, FindCancellingErrors) {
  const ShootingProblem problem = testing::cartpole_swing_up();
  Point at(problem);
  at.analytic.knots[0].F(1, 0) += 1e-6;
  at.analytic.knots[0].F(1, 1) -= 1e-6;
  EXPECT_EQ(at.models().by_dual_numbers, 1);
}

/// A chain of 200 bodies under weak torques amplifies rounding by over 100.
ShootingProblem long_chain() {
  RobotModel model = random_robot(3, {.joints = 200, .branching = 0, .prismatic = 0});
  const auto robot = std::make_shared<const RobotModel>(std::move(model));
  const auto chain = std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
  const int n = robot->nv;
  const testing::TrackingCost cost{.goal = std::vector<double>(2 * n, 0.0),
                                   .q = std::vector<double>(2 * n, 1.0),
                                   .r = std::vector<double>(n, 1.0),
                                   .qf = std::vector<double>(2 * n, 1.0)};
  return testing::tracking_problem(chain, Integrator::semi_implicit_euler, 1, 0.01,
                                   std::vector<double>(2 * n, 0.1), cost);
}

TEST(NodeModels, AllowForRoundingAmplifiedByAChain) {
  const ShootingProblem problem = long_chain();
  Point at(problem);
  const Eigen::MatrixXd own = at.analytic.knots[0].dense_jacobian();
  const auto reference = node_derivatives(problem, at.t, at.analytic.gap);
  EXPECT_GT(difference(reference[0].step, own), 1e-13) << "nothing is amplified";
  EXPECT_EQ(at.models().by_dual_numbers, 0);
  at.analytic.knots[0].F.data()[5] += 1e-4 * own.cwiseAbs().maxCoeff();
  EXPECT_EQ(at.models().by_dual_numbers, 1);
}

}  // namespace
}  // namespace conddp
