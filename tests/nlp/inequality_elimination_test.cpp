#include "nlp/inequality_elimination.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "nlp/chain_factorization.hpp"
#include "support/sparse_system.hpp"

namespace conddp {
namespace {

using testing::expect_solved;
using testing::SparseSystem;

/// Interior-point system in Ipopt's order: variables, slacks, equality multipliers, inequality
/// multipliers. `knots`: groups of three variables, each coupled with the next by two equalities.
/// `many`: inequalities per knot, on two variables each. `stiffest`: largest slack entry.
SparseSystem interior_system(int knots, int many, double stiffest, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> number(-1, 1), share(0, 1);
  SparseSystem system;
  const int slacks = 3 * knots, equalities = slacks + many * knots;
  const int multipliers = equalities + 2 * (knots - 1);
  for (int i = 0; i < slacks; ++i) {
    system.add(i, i, 2 + number(generator));
    if (i % 3 > 0) system.add(i, i - 1, 0.3 * number(generator));
  }
  for (int k = 0; k + 1 < knots; ++k)
    for (int r = 0; r < 2; ++r) {
      const int row = equalities + 2 * k + r;
      for (int c = 0; c < 3; ++c) system.add(row, 3 * k + c, number(generator));
      system.add(row, 3 * (k + 1) + r, -1);
      system.add(row, row, 0);
    }
  for (int i = 0; i < many * knots; ++i) {
    const int slack = slacks + i, row = multipliers + i, first = 3 * (i / many);
    system.add(slack, slack, std::pow(stiffest, share(generator)));
    system.add(row, slack, -1);
    system.add(row, first, number(generator));
    system.add(first + 1, row, number(generator));
    if (i % 3 == 0) system.add(row, first, number(generator));  // adds to the previous one
    system.add(row, row, i % 2 == 0 ? 0 : -1e-8);
  }
  return system;
}

TEST(InequalityElimination, SolvesAndCountsLikeTheWholeMatrix) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    const SparseSystem system = interior_system(6, 7, seed < 10 ? 10 : 1e6, seed);
    InequalityElimination factorization(ChainFactorization::make());
    system.analyse(factorization);
    EXPECT_EQ(factorization.eliminated(), 2 * 6 * 7);
    for (int i = 0; i < 2; ++i) expect_solved(system, factorization, 1e-8);
  }
}

// A variable coupled with only one other looks like a slack, and so may its neighbor.
TEST(InequalityElimination, KeepsOneOfTwoCoupledPairs) {
  SparseSystem system;
  for (int i = 0; i < 4; ++i) system.add(i, i, i % 2 == 0 ? 1 : -0.5);
  system.add(1, 0, 2);
  system.add(3, 2, 1);
  system.add(3, 1, 0.5);
  InequalityElimination factorization(ChainFactorization::make());
  system.analyse(factorization);
  EXPECT_EQ(factorization.eliminated(), 2);
  expect_solved(system, factorization, 1e-12);
}

TEST(InequalityElimination, PairWithoutInverseIsSingular) {
  SparseSystem system;
  system.add(0, 0, 1);
  system.add(1, 1, 0);
  system.add(2, 1, 0);
  system.add(2, 0, 1);
  system.add(2, 2, 0);
  InequalityElimination factorization(ChainFactorization::make());
  system.analyse(factorization);
  ASSERT_EQ(factorization.eliminated(), 2);
  EXPECT_EQ(factorization.factorize(system.values.data(), testing::kPivotTolerance),
            SymmetricFactorization::Outcome::singular);
}

}  // namespace
}  // namespace conddp
