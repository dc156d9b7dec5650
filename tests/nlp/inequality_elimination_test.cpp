#include "nlp/inequality_elimination.hpp"

#include <random>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "nlp/chain_factorization.hpp"
#include "nlp/nonlinear_program.hpp"

namespace conddp {
namespace {

using EliminationOutcome = SymmetricFactorization::Outcome;

constexpr double kEliminationTolerance = 1e-6;

/// The system of an interior point: variables, slacks, multipliers of equalities, and of
/// inequalities, in Ipopt's order.
struct InteriorSystem {
  int variables, inequalities, equalities;
  Sparsity structure;
  std::vector<double> values;

  int slack(int i) const { return variables + i; }
  int equality(int i) const { return variables + inequalities + i; }
  int inequality(int i) const { return variables + inequalities + equalities + i; }
  int size() const { return inequality(inequalities); }

  void add(int row, int column, double value) {
    structure.add(row, column);
    values.push_back(value);
  }
  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size(), size());
    for (std::size_t e = 0; e < values.size(); ++e) {
      const int r = structure.rows[e], c = structure.columns[e];
      A(r, c) += values[e];
      if (r != c) A(c, r) += values[e];
    }
    return A;
  }
};

/// `knots` of three variables, each coupled with the next by two equalities, with `many`
/// inequalities a knot, on two variables each; `stiffest`: the largest number of a slack.
InteriorSystem interior_system(int knots, int many, double stiffest, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> number(-1, 1), share(0, 1);
  InteriorSystem system{3 * knots, many * knots, 2 * (knots - 1), {}, {}};
  for (int i = 0; i < system.variables; ++i) {
    system.add(i, i, 2 + number(generator));
    if (i % 3 > 0) system.add(i, i - 1, 0.3 * number(generator));
  }
  for (int k = 0; k + 1 < knots; ++k)
    for (int r = 0; r < 2; ++r) {
      const int row = system.equality(2 * k + r);
      for (int c = 0; c < 3; ++c) system.add(row, 3 * k + c, number(generator));
      system.add(row, 3 * (k + 1) + r, -1);
      system.add(row, row, 0);
    }
  for (int i = 0; i < system.inequalities; ++i) {
    const int row = system.inequality(i), first = 3 * (i / many);
    system.add(system.slack(i), system.slack(i), std::pow(stiffest, share(generator)));
    system.add(row, system.slack(i), -1);
    system.add(row, first, number(generator));
    system.add(first + 1, row, number(generator));
    if (i % 3 == 0) system.add(row, first, number(generator));  // adds to the one before
    system.add(row, row, i % 2 == 0 ? 0 : -1e-8);
  }
  return system;
}

void analyse(SymmetricFactorization& factorization, const InteriorSystem& system) {
  factorization.analyse(system.size(), system.structure.size(), system.structure.rows.data(),
                        system.structure.columns.data());
}

TEST(InequalityElimination, SolvesAndCountsAsTheWholeMatrixDoes) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const InteriorSystem system = interior_system(6, 7, seed < 10 ? 10 : 1e6, seed);
    InequalityElimination factorization(ChainFactorization::make());
    analyse(factorization, system);
    EXPECT_EQ(factorization.eliminated(), 2 * system.inequalities);
    const Eigen::MatrixXd A = system.dense();
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(system.size(), -1, 2);
    for (int i = 0; i < 2; ++i) {
      ASSERT_EQ(factorization.factorize(system.values.data(), kEliminationTolerance),
                EliminationOutcome::done);
      Eigen::VectorXd b = A * x;
      factorization.solve(b.data());
      EXPECT_LE((A * (b - x)).lpNorm<Eigen::Infinity>(), 1e-9 * A.cwiseAbs().maxCoeff()) << seed;
      const Eigen::VectorXd eigenvalues = A.selfadjointView<Eigen::Lower>().eigenvalues();
      EXPECT_EQ(factorization.negative_eigenvalues(), (eigenvalues.array() < 0).count()) << seed;
    }
  }
}

// A variable that one other is coupled with looks like a slack, and so may that one's neighbors.
TEST(InequalityElimination, LeavesOneOfTwoPairsThatAreCoupled) {
  InteriorSystem system{4, 0, 0, {}, {}};
  for (int i = 0; i < 4; ++i) system.add(i, i, i % 2 == 0 ? 1 : -0.5);
  system.add(1, 0, 2);
  system.add(3, 2, 1);
  system.add(3, 1, 0.5);
  InequalityElimination factorization(ChainFactorization::make());
  analyse(factorization, system);
  EXPECT_EQ(factorization.eliminated(), 2);
  ASSERT_EQ(factorization.factorize(system.values.data(), kEliminationTolerance),
            EliminationOutcome::done);
  const Eigen::Vector4d x(1, -2, 3, 0.5);
  Eigen::VectorXd b = system.dense() * x;
  factorization.solve(b.data());
  EXPECT_LE((b - x).lpNorm<Eigen::Infinity>(), 1e-12);
  EXPECT_EQ(factorization.negative_eigenvalues(), 2);
}

TEST(InequalityElimination, APairWithoutInverseIsSingular) {
  InteriorSystem system{1, 1, 0, {}, {}};
  system.add(0, 0, 1);
  system.add(1, 1, 0);
  system.add(2, 1, 0);
  system.add(2, 0, 1);
  system.add(2, 2, 0);
  InequalityElimination factorization(ChainFactorization::make());
  analyse(factorization, system);
  ASSERT_EQ(factorization.eliminated(), 2);
  EXPECT_EQ(factorization.factorize(system.values.data(), kEliminationTolerance),
            EliminationOutcome::singular);
}

}  // namespace
}  // namespace conddp
