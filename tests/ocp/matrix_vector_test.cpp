#include "ocp/evaluation/matrix_vector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace conddp {
namespace {

/// Values that do not cancel in sums.
Eigen::MatrixXd sample(int rows, int cols, double phase) {
  Eigen::MatrixXd A(rows, cols);
  for (int i = 0; i < A.size(); ++i) A.data()[i] = std::sin(1.7 * i + phase);
  return A;
}

/// n results with guard values before and after them.
struct Guarded {
  static constexpr int kMargin = 8;
  explicit Guarded(const Eigen::VectorXd& content)
      : all(content.size() + 2 * kMargin, std::numeric_limits<double>::quiet_NaN()) {
    std::copy(content.begin(), content.end(), data());
  }
  double* data() { return all.data() + kMargin; }
  auto view() const {
    return Eigen::Map<const Eigen::VectorXd>(all.data() + kMargin,
                                             static_cast<Eigen::Index>(all.size()) - 2 * kMargin);
  }
  bool untouched() const {
    const auto is_nan = [](double a) { return std::isnan(a); };
    return std::all_of(all.begin(), all.begin() + kMargin, is_nan) &&
           std::all_of(all.end() - kMargin, all.end(), is_nan);
  }
  std::vector<double> all;
};

// Sizes around whole lanes and passes, and empty products.
TEST(MatrixVector, AgreesWithEigenForEverySize) {
  for (const int rows : {1, 2, 3, 7, 8, 9, 12, 16, 18, 36, 39, 40, 41, 76, 83})
    for (const int cols : {0, 1, 2, 5, 8, 11, 36, 48}) {
      const Eigen::MatrixXd A = sample(rows, cols, 0.3);
      const Eigen::VectorXd x = sample(cols, 1, 0.1), y = sample(rows, 1, 0.7);
      Guarded set(y), added(y);
      multiply(A, x.data(), set.data());
      multiply_add(A, x.data(), added.data());
      const double tolerance = 1e-14 * (1 + cols);
      EXPECT_LT((set.view() - A * x).lpNorm<Eigen::Infinity>(), tolerance) << rows << ' ' << cols;
      EXPECT_LT((added.view() - (y + A * x)).lpNorm<Eigen::Infinity>(), tolerance)
          << rows << ' ' << cols;
      EXPECT_TRUE(set.untouched() && added.untouched()) << rows << ' ' << cols;
    }
}

TEST(MatrixVector, TransposedAgreesWithEigenForEverySize) {
  for (const int rows : {0, 1, 2, 5, 8, 11, 12, 18, 38})
    for (const int cols : {1, 3, 7, 8, 9, 16, 36, 48, 108}) {
      const Eigen::MatrixXd A = sample(rows, cols, 0.3);
      const Eigen::VectorXd x = sample(rows, 1, 0.1);
      Guarded product(sample(cols, 1, 0.7));
      multiply_transposed(A, x.data(), product.data());
      EXPECT_LT((product.view() - A.transpose() * x).lpNorm<Eigen::Infinity>(), 1e-14 * (1 + rows))
          << rows << ' ' << cols;
      EXPECT_TRUE(product.untouched()) << rows << ' ' << cols;
    }
}

}  // namespace
}  // namespace conddp
