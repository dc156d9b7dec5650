#include "solvers/linalg/riccati_equation.hpp"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "support/random_numbers.hpp"

namespace conddp {
namespace {

using Matrix = Eigen::MatrixXd;

Matrix random_entries(int rows, int columns, RandomNumbers& random) {
  Matrix M(rows, columns);
  for (double& entry : M.reshaped()) entry = random.uniform(-1, 1);
  return M;
}

RegulatorProblem without_cross_term(Matrix A, Matrix B, Matrix Q, Matrix R) {
  const Matrix S = Matrix::Zero(B.rows(), B.cols());
  return {std::move(A), std::move(B), std::move(Q), std::move(R), S};
}

/// Cost of this many steps by the Riccati recursion.
Matrix recursion(const RegulatorProblem& p, int steps) {
  Matrix P = Matrix::Zero(p.A.rows(), p.A.rows());
  for (int k = 0; k < steps; ++k) {
    const Matrix F = p.A.transpose() * P * p.B + p.S;
    const Matrix next = p.Q + p.A.transpose() * P * p.A -
                        F * (p.R + p.B.transpose() * P * p.B).ldlt().solve(F.transpose());
    P = 0.5 * (next + next.transpose());
  }
  return P;
}

// The scalar equation a²p − p − (abp)²/(r + b²p) + q = 0 is quadratic.
TEST(RiccatiEquation, ScalarSolutionIsAPolynomialRoot) {
  const auto scalar = [](double value) { return Matrix::Constant(1, 1, value); };
  for (const double a : {0.0, 0.5, 1.0, 2.0, 50.0})
    for (const double b : {1e-3, 1.0, 30.0})
      for (const double q : {0.01, 1.0, 1e4}) {
        const double r = 0.7;
        const double h = r - a * a * r - b * b * q;  // b²p² + h p − q r = 0
        const double root = std::sqrt(h * h + 4 * b * b * q * r);
        const double p = h > 0 ? 2 * q * r / (h + root) : (root - h) / (2 * b * b);
        const RegulatorResult got =
            solve_regulator(without_cross_term(scalar(a), scalar(b), scalar(q), scalar(r)));
        ASSERT_TRUE(got.regulator) << a << ' ' << b << ' ' << q;
        EXPECT_NEAR(got.regulator->P(0, 0), p, 1e-11 * p) << a << ' ' << b << ' ' << q;
        EXPECT_NEAR(got.regulator->K(0, 0), a * b * p / (r + b * b * p),
                    1e-11 * (1 + std::abs(a / b)));
      }
}

// Double integrator with a constant control over 0.1 s; Q = I and R = 0.1 are rates.
TEST(RiccatiEquation, DoubleIntegratorHasItsKnownSolution) {
  const double h = 0.1;
  const RegulatorResult got = solve_regulator(
      without_cross_term(Matrix{{1, h}, {0, 1}}, Matrix{{h * h / 2}, {h}},
                         h * Matrix::Identity(2, 2), Matrix::Constant(1, 1, 0.1 * h)));
  ASSERT_TRUE(got.regulator);
  EXPECT_NEAR(got.regulator->P(0, 0), 1.3317224441130, 1e-12);
  EXPECT_NEAR(got.regulator->P(0, 1), 0.3201562118716, 1e-12);
  EXPECT_NEAR(got.regulator->P(1, 1), 0.4603514023781, 1e-12);
  EXPECT_NEAR(got.regulator->K(0, 0), 2.5857008966598, 1e-12);
  EXPECT_NEAR(got.regulator->K(0, 1), 3.4434359178453, 1e-12);
  EXPECT_LT(got.regulator->residual, 1e-14);
}

TEST(RiccatiEquation, RandomSolutionsAreLongHorizonLimits) {
  RandomNumbers random(31);
  for (int i = 0; i < 50; ++i) {
    const int n = 1 + i % 7, m = 1 + i % 3;
    const Matrix half = random_entries(n + m, n + m, random);
    const Matrix cost = half * half.transpose() + 0.01 * Matrix::Identity(n + m, n + m);
    const RegulatorProblem p{1.2 * random_entries(n, n, random), random_entries(n, m, random),
                             cost.topLeftCorner(n, n), cost.bottomRightCorner(m, m),
                             cost.topRightCorner(n, m)};
    const RegulatorResult got = solve_regulator(p);
    ASSERT_TRUE(got.regulator) << i;
    const Matrix limit = recursion(p, 20000);
    EXPECT_LT((got.regulator->P - limit).norm(), 1e-10 * limit.norm()) << i;
    EXPECT_LT(got.regulator->residual, 1e-12) << i;
    EXPECT_LT(std::abs(got.regulator->eigenvalues[0]), 1) << i;
  }
}

// Two decoupled double integrators: double eigenvalues are semisimple across the systems and
// defective within each.
TEST(RiccatiEquation, DecoupledSystemsAreSolvedIndependently) {
  const Matrix A{{1, 0.1}, {0, 1}}, B{{0.005}, {0.1}};
  const Matrix Q = 0.1 * Matrix::Identity(2, 2), R = Matrix::Constant(1, 1, 0.01);
  const RegulatorResult one = solve_regulator(without_cross_term(A, B, Q, R));
  Matrix A2 = Matrix::Zero(4, 4), B2 = Matrix::Zero(4, 2);
  A2 << A, Matrix::Zero(2, 2), Matrix::Zero(2, 2), A;
  B2 << B, Matrix::Zero(2, 1), Matrix::Zero(2, 1), B;
  const RegulatorResult two = solve_regulator(
      without_cross_term(A2, B2, 0.1 * Matrix::Identity(4, 4), 0.01 * Matrix::Identity(2, 2)));
  ASSERT_TRUE(one.regulator && two.regulator);
  EXPECT_LT((two.regulator->P.topLeftCorner(2, 2) - one.regulator->P).norm(), 1e-13);
  EXPECT_LT((two.regulator->P.bottomRightCorner(2, 2) - one.regulator->P).norm(), 1e-13);
  EXPECT_LT(two.regulator->P.topRightCorner(2, 2).norm(), 1e-13);
}

// With B = (1, ε), only ε controls the unstable second mode: p₂₂ grows like 1/ε², and the closed
// loop mirrors the unstable eigenvalue.
TEST(RiccatiEquation, StabilizesWeaklyControllableModes) {
  for (const double epsilon : {1e-2, 1e-3, 1e-4}) {
    const RegulatorResult got =
        solve_regulator(without_cross_term(Matrix{{0.5, 0}, {0, 1.25}}, Matrix{{1}, {epsilon}},
                                           1e-6 * Matrix::Identity(2, 2), Matrix::Identity(1, 1)));
    ASSERT_TRUE(got.regulator) << epsilon;
    EXPECT_NEAR(got.regulator->eigenvalues[0].real(), 0.8, 1e-5) << epsilon;
    EXPECT_LT(got.regulator->residual, 1e-10) << epsilon;
  }
}

TEST(RiccatiEquation, NamesUncontrollableUnstableModes) {
  RandomNumbers random(7);
  const Matrix T = random_entries(4, 4, random);
  Matrix A = Matrix::Zero(4, 4);
  A.diagonal() << 0.5, 1.5, 1.1, 0.9;
  Matrix B{{1}, {1}, {0}, {0}};
  const RegulatorResult plain =
      solve_regulator(without_cross_term(A, B, Matrix::Identity(4, 4), Matrix::Identity(1, 1)));
  EXPECT_EQ(plain.fault, RegulatorFault::not_stabilizable);
  ASSERT_TRUE(plain.mode);
  EXPECT_NEAR(plain.mode->eigenvalue.real(), 1.1, 1e-12);
  EXPECT_NEAR(plain.mode->share[2], 1, 1e-12);
  EXPECT_LT(plain.mode->share[0] + plain.mode->share[1], 1e-12);
  const RegulatorResult mixed = solve_regulator(without_cross_term(
      T * A * T.inverse(), T * B, Matrix::Identity(4, 4), Matrix::Identity(1, 1)));
  EXPECT_EQ(mixed.fault, RegulatorFault::not_stabilizable);
  ASSERT_TRUE(mixed.mode);
  EXPECT_NEAR(mixed.mode->eigenvalue.real(), 1.1, 1e-9);
}

// One control on two equal integrators moves only their sum.
TEST(RiccatiEquation, EqualModesNeedAControlEach) {
  const RegulatorResult got = solve_regulator(without_cross_term(
      Matrix::Identity(2, 2), Matrix::Ones(2, 1), Matrix::Identity(2, 2), Matrix::Identity(1, 1)));
  EXPECT_EQ(got.fault, RegulatorFault::not_stabilizable);
  ASSERT_TRUE(got.mode);
  EXPECT_NEAR(std::abs(got.mode->eigenvalue), 1, 1e-12);
  EXPECT_NEAR(got.mode->share.minCoeff(), 1, 1e-12);
}

TEST(RiccatiEquation, AcceptsUncontrollableStableModes) {
  const RegulatorResult got =
      solve_regulator(without_cross_term(Matrix{{0.9, 0}, {0, 1.2}}, Matrix{{0}, {1}},
                                         Matrix::Identity(2, 2), Matrix::Identity(1, 1)));
  ASSERT_TRUE(got.regulator);
  EXPECT_NEAR(got.regulator->P(0, 0), 1 / (1 - 0.81), 1e-12);
}

// The mode is uncontrollable, and rounding could make it persist.
TEST(RiccatiEquation, ModeDecayingByRoundingPersists) {
  const auto with_decay = [](double decay) {
    return solve_regulator(without_cross_term(Matrix{{1 - decay, 0}, {0, 1.2}}, Matrix{{0}, {1}},
                                              Matrix::Identity(2, 2), Matrix::Identity(1, 1)));
  };
  const RegulatorResult lasting = with_decay(1e-8);
  EXPECT_EQ(lasting.fault, RegulatorFault::not_stabilizable);
  ASSERT_TRUE(lasting.mode);
  EXPECT_NEAR(lasting.mode->share[0], 1, 1e-12);
  EXPECT_TRUE(with_decay(1e-3).regulator);
}

TEST(RiccatiEquation, NamesCostlessPersistentModes) {
  Matrix Q = Matrix::Zero(2, 2);
  Q(1, 1) = 1;
  const RegulatorResult got = solve_regulator(without_cross_term(
      Matrix{{1, 0.1}, {0, 1}}, Matrix{{0.005}, {0.1}}, Q, Matrix::Identity(1, 1)));
  EXPECT_EQ(got.fault, RegulatorFault::not_detectable);
  ASSERT_TRUE(got.mode);
  EXPECT_NEAR(got.mode->share[0], 1, 1e-12);
}

TEST(RiccatiEquation, NamesNonconvexCosts) {
  const Matrix I = Matrix::Identity(1, 1);
  EXPECT_EQ(solve_regulator(without_cross_term(I, I, I, 0 * I)).fault,
            RegulatorFault::control_cost);
  EXPECT_EQ(solve_regulator(without_cross_term(I, I, I, -I)).fault, RegulatorFault::control_cost);
  EXPECT_EQ(solve_regulator(without_cross_term(I, I, -I, I)).fault, RegulatorFault::state_cost);
  const RegulatorResult cross = solve_regulator({I, I, I, I, 2 * I});  // Q − S R⁻¹ Sᵀ = −3
  EXPECT_EQ(cross.fault, RegulatorFault::state_cost);
  EXPECT_NEAR(cross.eigenvalue, -3, 1e-12);
}

}  // namespace
}  // namespace conddp
