#include "systems/multibody/dense_ldlt.hpp"

namespace conddp {

template <class S>
void factorize_ldlt(int n, S* A) {
  for (int k = 0; k < n; ++k) {
    S* pivot = A + k * n;
    pivot[k] = S(1.0) / pivot[k];
    for (int j = k + 1; j < n; ++j) {
      const S factor = pivot[j] * pivot[k];
      for (int i = j; i < n; ++i) A[j * n + i] -= pivot[i] * factor;
    }
    for (int i = k + 1; i < n; ++i) pivot[i] *= pivot[k];
  }
}

template <class S>
void solve_ldlt(int n, const S* factors, S* x) {
  for (int k = 0; k < n; ++k)
    for (int i = k + 1; i < n; ++i) x[i] -= factors[k * n + i] * x[k];
  for (int k = n - 1; k >= 0; --k) {
    S sum = x[k] * factors[k * n + k];
    for (int i = k + 1; i < n; ++i) sum -= factors[k * n + i] * x[i];
    x[k] = sum;
  }
}

#define CONDDP_INSTANTIATE(S)                \
  template void factorize_ldlt(int n, S* A); \
  template void solve_ldlt(int n, const S*, S*);
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
