#pragma once

#include "spatial/dual.hpp"

namespace conddp {

namespace detail {
inline bool is_not_zero(double a) { return a != 0; }
inline LaneMask is_not_zero(Lane a) { return !(a == Lane(0.0)); }
template <class S>
auto is_not_zero(const Dual<S>& a) {
  return is_not_zero(a.v) | is_not_zero(a.d);
}
}  // namespace detail

/// True if all numbers are zero in all lanes.
template <class S>
bool all_zero(const S* a, int n) {
  auto found = S(1.0) < S(0.0);
  for (int i = 0; i < n; ++i) found = found | detail::is_not_zero(a[i]);
  return !any(found);
}

/// Σ a_i b_i over n ≥ 1 numbers.
template <class S>
S dot(int n, const S* a, const S* b) {
  S sum = a[0] * b[0];
  for (int i = 1; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// H(a, b) += J_aᵀ T_b for all pairs of columns a ≥ b; `pair` lists their indices in H. Two columns
/// a at a time, so that each column of T is read once for both. kRows is the number of rows, or 0
/// to use `rows`.
template <int kRows, class S>
void add_products(int rows, int columns, const S* J, const S* T, const int* pair, S* H) {
  if (kRows > 0) rows = kRows;
  int a = 0;
  for (; a + 1 < columns; a += 2) {
    const S *first = J + a * rows, *second = first + rows;
    const int* second_pair = pair + a + 1;
    for (int b = 0; b <= a; ++b) {
      const S* t = T + b * rows;
      S &h = H[pair[b]], &g = H[second_pair[b]];
      S x = h, y = g;
#pragma GCC unroll 6
      for (int i = 0; i < rows; ++i) x += first[i] * t[i], y += second[i] * t[i];
      h = x;
      g = y;
    }
    const S* t = T + (a + 1) * rows;
    for (int i = 0; i < rows; ++i) H[second_pair[a + 1]] += second[i] * t[i];
    pair = second_pair + a + 2;
  }
  if (a == columns) return;
  for (int b = 0; b <= a; ++b)
    for (int i = 0; i < rows; ++i) H[pair[b]] += J[a * rows + i] * T[b * rows + i];
}

template <class S>
void add_products(int rows, int columns, const S* J, const S* T, const int* pair, S* H) {
  switch (rows) {
    case 1:
      return add_products<1>(rows, columns, J, T, pair, H);
    case 2:
      return add_products<2>(rows, columns, J, T, pair, H);
    case 3:
      return add_products<3>(rows, columns, J, T, pair, H);
    case 6:
      return add_products<6>(rows, columns, J, T, pair, H);
    default:
      return add_products<0>(rows, columns, J, T, pair, H);
  }
}

}  // namespace conddp
