#include "nlp/chain_factorization.hpp"

#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "support/sparse_system.hpp"

namespace conddp {
namespace {

using ChainOutcome = SymmetricFactorization::Outcome;

using testing::expect_solved;
using testing::SparseSystem;

constexpr double kChainTolerance = testing::kPivotTolerance;

/// Optimality conditions of a horizon: knots of states and controls with a Hessian, and rows A x +
/// B u − x⁺ = 0 between them. `curved`: fraction of unknowns with a Hessian entry.
SparseSystem horizon(int knots, int nx, int nu, double curved, std::mt19937& generator) {
  std::uniform_real_distribution<double> number(-1, 1), share(0, 1);
  SparseSystem system;
  const int stage = nx + nu, rows = (knots + 1) * nx + knots * nu;
  for (int k = 0; k <= knots; ++k) {
    const int width = k < knots ? stage : nx;
    for (int c = 0; c < width; ++c) {
      system.add(k * stage + c, k * stage + c,
                 share(generator) < curved ? 2 + number(generator) : 0);
      for (int r = c + 1; r < width; ++r)
        system.add(k * stage + r, k * stage + c, 0.1 * curved * number(generator));
    }
  }
  for (int k = 0; k < knots; ++k)
    for (int r = 0; r < nx; ++r) {
      for (int c = 0; c < stage; ++c)
        system.add(rows + k * nx + r, k * stage + c, number(generator));
      system.add(rows + k * nx + r, (k + 1) * stage + r, -1);
    }
  return system;
}

struct HorizonCase {
  int knots, nx, nu;
  double curved;
};

class Horizons : public ::testing::TestWithParam<HorizonCase> {};

TEST_P(Horizons, AreSolvedForAnyOrderOfUnknowns) {
  const auto [knots, nx, nu, curved] = GetParam();
  std::mt19937 generator(7);
  for (int i = 0; i < 5; ++i) {
    SparseSystem system = horizon(knots, nx, nu, curved, generator);
    system.shuffle(generator);
    ChainFactorization factorization;
    system.analyse(factorization);
    expect_solved(system, factorization, 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Horizons,
                         ::testing::Values(HorizonCase{1, 1, 1, 1}, HorizonCase{6, 2, 1, 1},
                                           HorizonCase{6, 2, 1, 0.8}, HorizonCase{12, 5, 2, 1},
                                           HorizonCase{4, 9, 4, 0.9}));

TEST(Chain, HorizonHasNarrowGroups) {
  std::mt19937 generator(1);
  SparseSystem system = horizon(40, 3, 1, 1, generator);
  system.shuffle(generator);
  const Chain chain(system.size, system.structure.size(), system.structure.rows.data(),
                    system.structure.columns.data());
  std::size_t unknowns = 0;
  for (const auto& group : chain.groups) {
    unknowns += group.size();
    EXPECT_LE(group.size(), 8u);
  }
  EXPECT_EQ(unknowns, static_cast<std::size_t>(system.size));
  EXPECT_GE(chain.groups.size(), 41u);
  EXPECT_FALSE(chain.goes_on.back());
}

TEST(ChainFactorization, SolvesDecoupledPieces) {
  SparseSystem system;
  system.add(0, 0, 4);
  system.add(1, 2, 3);  // a pair without diagonal
  system.add(3, 3, -2);
  system.add(3, 4, 1);
  system.add(4, 4, 5);
  ChainFactorization factorization;
  system.analyse(factorization);
  expect_solved(system, factorization, 1e-14);
}

TEST(ChainFactorization, SumsEntriesFromEitherTriangle) {
  SparseSystem system;
  system.add(0, 0, 4);
  system.add(1, 0, 1);
  system.add(0, 1, 0.5);
  system.add(1, 1, 2);
  system.add(1, 1, 1);
  ChainFactorization factorization;
  system.analyse(factorization);
  ASSERT_EQ(factorization.factorize(system.values.data(), kChainTolerance), ChainOutcome::done);
  Eigen::Vector2d b(4 + 2 * 1.5, 1.5 + 2 * 3);
  factorization.solve(b.data());
  EXPECT_LE((b - Eigen::Vector2d(1, 2)).norm(), 1e-14);
}

TEST(ChainFactorization, DelaysPivotsWithZeroDiagonals) {
  // A path without diagonals: each unknown can be eliminated only together with its neighbor.
  SparseSystem system;
  for (int i = 0; i + 1 < 20; ++i) system.add(i + 1, i, 1 + 0.1 * i);
  ChainFactorization factorization;
  system.analyse(factorization);
  expect_solved(system, factorization, 1e-10);
}

TEST(ChainFactorization, SolvesSystemsWithWidelyScaledEntries) {
  std::mt19937 generator(5);
  SparseSystem system = horizon(10, 3, 2, 1, generator);
  std::vector<double> unit(static_cast<std::size_t>(system.size));
  std::uniform_real_distribution<double> exponent(-6, 6);
  for (double& factor : unit) factor = std::pow(10, exponent(generator));
  for (std::size_t e = 0; e < system.values.size(); ++e)
    system.values[e] *= unit[static_cast<std::size_t>(system.structure.rows[e])] *
                        unit[static_cast<std::size_t>(system.structure.columns[e])];
  ChainFactorization factorization;
  system.analyse(factorization);
  ASSERT_EQ(factorization.factorize(system.values.data(), kChainTolerance), ChainOutcome::done);
  EXPECT_EQ(factorization.negative_eigenvalues(), 30);
  Eigen::VectorXd x(system.size);
  for (int i = 0; i < system.size; ++i) x[i] = 1 / unit[static_cast<std::size_t>(i)];
  Eigen::VectorXd b = system.dense() * x;
  factorization.solve(b.data());
  EXPECT_LE((b.cwiseQuotient(x) - Eigen::VectorXd::Ones(system.size)).lpNorm<Eigen::Infinity>(),
            1e-6);
}

TEST(ChainFactorization, CallsMatricesWithEqualRowsSingular) {
  SparseSystem system;
  for (int i = 0; i < 3; ++i) system.add(i, i, 1);
  for (int row : {3, 4})
    for (int c = 0; c < 3; ++c) system.add(row, c, c + 1);
  ChainFactorization factorization;
  system.analyse(factorization);
  EXPECT_EQ(factorization.factorize(system.values.data(), kChainTolerance), ChainOutcome::singular);
  system.values.back() += 1;
  expect_solved(system, factorization, 1e-12);
}

TEST(ChainFactorization, CallsMatricesWithEmptyRowsSingular) {
  SparseSystem system;
  system.add(0, 0, 1);
  system.add(1, 1, 0);
  ChainFactorization factorization;
  system.analyse(factorization);
  EXPECT_EQ(factorization.factorize(system.values.data(), kChainTolerance), ChainOutcome::singular);
}

TEST(ChainFactorization, CallsNonFiniteMatricesSingular) {
  SparseSystem system;
  system.add(0, 0, std::nan(""));
  system.add(1, 1, 1);
  ChainFactorization factorization;
  system.analyse(factorization);
  EXPECT_EQ(factorization.factorize(system.values.data(), kChainTolerance), ChainOutcome::singular);
}

TEST(ChainFactorization, RefactorizesTheSameStructureWithOtherValues) {
  std::mt19937 generator(9);
  SparseSystem system = horizon(6, 2, 1, 1, generator);
  ChainFactorization factorization;
  system.analyse(factorization);
  expect_solved(system, factorization, 1e-10);
  for (double& value : system.values) value = 1.5 * value + 0.01;
  expect_solved(system, factorization, 1e-8);
}

}  // namespace
}  // namespace conddp
