#include "solvers/linalg/low_rank_update.hpp"

#include <gtest/gtest.h>

#include "support/dense_horizon.hpp"

namespace conddp::testing {
namespace {

Eigen::MatrixXd random_matrix(int rows, int columns, RandomNumbers& random) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.uniform(-1, 1); });
}

/// Three states, two controls, and `rows` constraint rows per knot and at the end.
ShootingProblem problem_with_rows(int rows) {
  const LinearQuadratic lq(1, 3, {2}, 2, -kFree, kFree);
  return with_constraints(*lq.problem,
                          {affine_rows(Eigen::MatrixXd::Ones(rows, 5), *lq.problem, 0, 1, -1, 1),
                           affine_rows(Eigen::MatrixXd::Ones(rows, 3), *lq.problem, 2, 2, -1, 1)});
}

TEST(LowRankUpdate, AddsTheDenseProductForAnyRowCount) {
  RandomNumbers random(1);
  for (int rows = 1; rows <= 14; ++rows) {
    const ShootingProblem problem = problem_with_rows(rows);
    Linearization linearization(problem);
    LowRankUpdate update(problem);
    for (const int node : {0, 2, 1}) {  // the last node's rows are shorter
      SCOPED_TRACE(std::to_string(rows) + " rows, node " + std::to_string(node));
      const int nz = node < 2 ? 5 : 3;
      KnotHessian& hessian = linearization.knots[node].hessian;
      const Eigen::MatrixXd root = random_matrix(nz, nz, random);
      hessian.change() = root + root.transpose();
      const Eigen::MatrixXd C = random_matrix(rows, nz, random);
      Eigen::MatrixXd W = random_matrix(rows, rows, random);
      W = (W + W.transpose()).eval();
      // First rows individually, with weights of both signs; the others in blocks of up to four.
      const int single = rows / 3;
      Eigen::MatrixXd expected = hessian();
      EXPECT_TRUE(update.empty());
      for (int i = 0; i < single; ++i) {
        update.add(C.row(i), W(i, i));
        expected += W(i, i) * C.row(i).transpose() * C.row(i);
      }
      for (int at = single; at < rows; at += 4) {
        const int n = std::min(4, rows - at);
        const Eigen::MatrixXd here = C.middleRows(at, n), weight = W.block(at, at, n, n);
        update.add(here, weight);
        expected += here.transpose() * weight * here;
      }
      EXPECT_FALSE(update.empty());
      update.apply(hessian);
      EXPECT_TRUE(update.empty());
      EXPECT_LT((hessian() - expected).lpNorm<Eigen::Infinity>(), 1e-13 * rows);
    }
  }
}

// Initially only the costs' entries are filled; an update adds others.
TEST(LowRankUpdate, MarksHessianFillBeyondTheCosts) {
  const ShootingProblem problem = problem_with_rows(1);
  Linearization linearization(problem);
  Evaluator(problem).differentiate(problem.create_trajectory(), linearization);
  KnotHessian& hessian = linearization.knots[0].hessian;
  ASSERT_EQ(hessian.fill(), HessianFill::lasting);
  const Eigen::MatrixXd before = hessian();
  LowRankUpdate update(problem);
  const Eigen::RowVectorXd c = Eigen::RowVectorXd::LinSpaced(5, 1, 5);
  update.add(c, 2);
  update.apply(hessian);
  EXPECT_EQ(hessian.fill(), HessianFill::pattern);
  EXPECT_EQ(hessian(), before + 2 * c.transpose() * c);
  update.add(c, -2);
  hessian.change(HessianFill::all);
  update.apply(hessian);
  EXPECT_EQ(hessian.fill(), HessianFill::all);
  EXPECT_LT((hessian() - before).lpNorm<Eigen::Infinity>(), 1e-13);
}

// Memory fits the node with the most rows and columns, wherever it is.
TEST(LowRankUpdate, FitsTheLargestNode) {
  for (const bool first : {true, false}) {
    const LinearQuadratic lq(1, 3, first ? std::vector{5, 1} : std::vector{1, 5}, 1, -kFree, kFree);
    const int node = first ? 0 : 1;
    const ShootingProblem problem = with_constraints(
        *lq.problem, {affine_rows(Eigen::MatrixXd::Ones(7, 8), *lq.problem, node, node, -1, 1)});
    Linearization linearization(problem);
    KnotHessian& hessian = linearization.knots[node].hessian;
    hessian.change().setZero();
    RandomNumbers random(3);
    const Eigen::MatrixXd C = random_matrix(7, 8, random);
    LowRankUpdate update(problem);
    for (int i = 0; i < 7; ++i) update.add(C.row(i), 1 + i);
    update.apply(hessian);
    const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(7, 1, 7);
    EXPECT_LT((hessian() - C.transpose() * weights.asDiagonal() * C).norm(), 1e-13);
  }
}

}  // namespace
}  // namespace conddp::testing
