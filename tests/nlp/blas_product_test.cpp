#include <array>
#include <cmath>
#include <random>
#include <utility>

#include <dlfcn.h>

#include <Eigen/Core>
#include <gtest/gtest.h>

extern "C" void dgemm_(const char*, const char*, const int* m, const int* n, const int* k,
                       const double* alpha, const double* a, const int* lda, const double* b,
                       const int* ldb, const double* beta, double* c, const int* ldc);

namespace conddp {
namespace {

using Eigen::MatrixXd;

MatrixXd random_matrix(int rows, int columns, std::mt19937_64& engine) {
  std::uniform_real_distribution<double> number(-1, 1);
  return MatrixXd::NullaryExpr(rows, columns, [&] { return number(engine); });
}

TEST(BlasProduct, SharedLibrariesFindItInTheProgram) {
  EXPECT_EQ(dlsym(RTLD_DEFAULT, "dgemm_"), reinterpret_cast<void*>(&dgemm_));
}

TEST(BlasProduct, IsThatOfBlasForAllOperationsSizesAndStrides) {
  std::mt19937_64 engine(3);
  for (const auto& [m, n, k] : {std::array{1, 1, 1},
                                {3, 1, 7},
                                {1, 5, 2},
                                {8, 9, 4},
                                {33, 40, 21},
                                {4, 4, 0},
                                {0, 3, 2},
                                {3, 0, 2},
                                {60, 3, 90},
                                {7, 90, 50}})
    for (const char a_is : {'N', 'T', 'n', 'c'})
      for (const char b_is : {'N', 't'})
        for (const auto& [alpha, beta] :
             {std::pair{1.0, 0.0}, {-1.0, 1.0}, {0.5, -2.0}, {0.0, 3.0}}) {
          const bool at = a_is != 'N' && a_is != 'n', bt = b_is != 'N';
          const MatrixXd A = random_matrix((at ? k : m) + 2, (at ? m : k) + 1, engine);
          const MatrixXd B = random_matrix((bt ? n : k) + 1, (bt ? k : n) + 1, engine);
          MatrixXd C = random_matrix(m + 3, n + 1, engine);
          MatrixXd want = C;
          for (int i = 0; i < m; ++i)
            for (int j = 0; j < n; ++j) {
              double sum = 0;
              for (int l = 0; l < k; ++l)
                sum += (at ? A(l, i) : A(i, l)) * (bt ? B(j, l) : B(l, j));
              want(i, j) = alpha * sum + beta * C(i, j);
            }
          // What is there does not count where beta is zero.
          if (beta == 0) C.topLeftCorner(m, n).setConstant(std::nan(""));
          const int lda = static_cast<int>(A.rows()), ldb = static_cast<int>(B.rows()), ldc = m + 3;
          dgemm_(&a_is, &b_is, &m, &n, &k, &alpha, A.data(), &lda, B.data(), &ldb, &beta, C.data(),
                 &ldc);
          EXPECT_LE((C - want).norm(), 1e-13) << m << n << k << a_is << b_is;
        }
}

}  // namespace
}  // namespace conddp
