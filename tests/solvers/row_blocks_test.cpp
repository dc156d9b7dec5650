#include "solvers/interior/row_blocks.hpp"

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "support/conic_problems.hpp"
#include "support/random_numbers.hpp"

namespace conddp {
namespace {

/// A conic problem linearized at zero, with random factors of its rows and random steps.
struct Rows {
  Rows()
      : conic(1, testing::middle_size()),
        problem(*conic.problem),
        linearization(problem),
        blocks(problem),
        factors(Eigen::VectorXd::Zero(problem.constraint_rows())) {
    Evaluator(problem).differentiate(problem.create_trajectory(), linearization);
    RandomNumbers random(3);
    for (const NodeConstraint& c : problem.constraints())
      for (double& f : factors.segment(c.row, c.term->rows)) f = random.uniform(0.1, 1);
    for (int k = 0; k <= problem.knots(); ++k) {
      Eigen::VectorXd& step = z.emplace_back(problem.knot(k).model->nz());
      for (double& d : step) d = random.uniform(-1, 1);
    }
  }
  auto of_node(const Eigen::VectorXd& rows, int k) const {
    return rows.segment(problem.constraint_offset(k), linearization.knots[k].C.rows());
  }

  testing::ConicLinearQuadratic conic;
  const ShootingProblem& problem;
  Linearization linearization;
  RowBlocks blocks;
  Eigen::VectorXd factors;
  std::vector<Eigen::VectorXd> z;
};

TEST(RowBlocks, MatchDenseProducts) {
  Rows rows;
  Linearization with = rows.linearization;
  std::vector<Eigen::MatrixXd> squares;
  for (const Eigen::VectorXd& step : rows.z)
    squares.push_back(Eigen::MatrixXd::Zero(step.size(), step.size()));
  Eigen::VectorXd along = Eigen::VectorXd::Zero(rows.factors.size());
  rows.blocks.add_gradients(rows.factors, with);
  rows.blocks.add_squares(rows.factors, rows.linearization, squares);
  rows.blocks.multiply(rows.linearization, rows.z, along);
  for (int k = 0; k <= rows.problem.knots(); ++k) {
    const Eigen::MatrixXd& C = rows.linearization.knots[k].C;
    if (C.rows() == 0) continue;
    const auto f = rows.of_node(rows.factors, k);
    const Eigen::VectorXd gradient = rows.linearization.knots[k].gradient + C.transpose() * f;
    EXPECT_LT((with.knots[k].gradient - gradient).norm(), 1e-12 * (1 + gradient.norm())) << k;
    const Eigen::MatrixXd square = C.transpose() * f.asDiagonal() * C;
    const Eigen::MatrixXd got = squares[k].selfadjointView<Eigen::Lower>();
    EXPECT_LT((got - square).norm(), 1e-12 * (1 + square.norm())) << k;
    EXPECT_TRUE(squares[k].isLowerTriangular(0)) << k;
    const Eigen::VectorXd error = rows.of_node(along, k) - C * rows.z[k];
    EXPECT_LT(error.cwiseProduct(f).norm(), 1e-12) << k;
  }
}

}  // namespace
}  // namespace conddp
