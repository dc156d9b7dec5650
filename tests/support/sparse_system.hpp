#pragma once

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "nlp/nonlinear_program.hpp"
#include "nlp/symmetric_factorization.hpp"

namespace conddp::testing {

inline constexpr double kPivotTolerance = 1e-6;

/// A sparse symmetric matrix with renumberable unknowns.
struct SparseSystem {
  int size = 0;
  Sparsity structure;
  std::vector<double> values;

  void add(int row, int column, double value) {
    structure.add(row, column);
    values.push_back(value);
    size = std::max({size, row + 1, column + 1});
  }
  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t e = 0; e < values.size(); ++e) {
      const int r = structure.rows[e], c = structure.columns[e];
      A(r, c) += values[e];
      if (r != c) A(c, r) += values[e];
    }
    return A;
  }
  void shuffle(std::mt19937& generator) {
    std::vector<int> number(static_cast<std::size_t>(size));
    std::iota(number.begin(), number.end(), 0);
    std::shuffle(number.begin(), number.end(), generator);
    for (auto* indices : {&structure.rows, &structure.columns})
      for (int& index : *indices) index = number[static_cast<std::size_t>(index)];
  }
  void analyse(SymmetricFactorization& factorization) const {
    factorization.analyse(size, structure.size(), structure.rows.data(), structure.columns.data());
  }
};

/// Checks the solution and the number of negative eigenvalues after `analyse`.
inline void expect_solved(const SparseSystem& system, SymmetricFactorization& factorization,
                          double accuracy) {
  ASSERT_EQ(factorization.factorize(system.values.data(), kPivotTolerance),
            SymmetricFactorization::Outcome::done);
  const Eigen::MatrixXd A = system.dense();
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(system.size, -1, 2);
  Eigen::VectorXd b = A * x;
  factorization.solve(b.data());
  EXPECT_LE((b - x).lpNorm<Eigen::Infinity>(), accuracy);
  const Eigen::VectorXd eigenvalues = A.selfadjointView<Eigen::Lower>().eigenvalues();
  EXPECT_EQ(factorization.negative_eigenvalues(), (eigenvalues.array() < 0).count());
}

}  // namespace conddp::testing
