// BLAS's dgemm_ for Ipopt's linear solver.
//
// With large robots MUMPS spends more than half of its time in dgemm_, which is a plain loop in the
// reference BLAS that Debian's Ipopt comes with. A definition in the program goes before that of a
// shared library, so MUMPS finds this one.
#include <dlfcn.h>

#include <Eigen/Core>

namespace {

using Map = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using Product = void(const char*, const char*, const int*, const int*, const int*, const double*,
                     const double*, const int*, const double*, const int*, const double*, double*,
                     const int*);

/// Multiplications, m n k, from which on a blocked product pays.
constexpr double kLargeProduct = 1e4;

bool is_transposed(const char* operation) { return *operation != 'N' && *operation != 'n'; }

}  // namespace

/// C ← α op(A) op(B) + β C with op(A) m x k and op(B) k x n, by columns, as BLAS has it. Small
/// products are left to the library's own function.
extern "C" void dgemm_(const char* operation_a, const char* operation_b, const int* m, const int* n,
                       const int* k, const double* alpha, const double* a, const int* lda,
                       const double* b, const int* ldb, const double* beta, double* c,
                       const int* ldc) {
  static Product* const library = reinterpret_cast<Product*>(dlsym(RTLD_NEXT, "dgemm_"));
  if (static_cast<double>(*m) * *n * *k < kLargeProduct && library != nullptr)
    return library(operation_a, operation_b, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc);

  Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> C(c, *m, *n, Eigen::OuterStride<>(*ldc));
  // What C holds may be no numbers where β is zero.
  if (*beta == 0)
    C.setZero();
  else if (*beta != 1)
    C *= *beta;
  const bool at = is_transposed(operation_a), bt = is_transposed(operation_b);
  const Map A(a, at ? *k : *m, at ? *m : *k, Eigen::OuterStride<>(*lda));
  const Map B(b, bt ? *n : *k, bt ? *k : *n, Eigen::OuterStride<>(*ldb));
  if (at && bt)
    C.noalias() += *alpha * A.transpose() * B.transpose();
  else if (at)
    C.noalias() += *alpha * A.transpose() * B;
  else if (bt)
    C.noalias() += *alpha * A * B.transpose();
  else
    C.noalias() += *alpha * A * B;
}
