#pragma once

#include "systems/system.hpp"

namespace conddp {

/// Factors a symmetric positive definite matrix (n x n by columns, lower triangle) in place: A = L
/// D Lᵀ. The unit lower triangle L is stored below the diagonal and D⁻¹ on it. Each lane holds its
/// own matrix; no pivoting, hence no branches.
template <class S>
void factorize_ldlt(int n, S* A);

/// x ← A⁻¹ x with the factors.
template <class S>
void solve_ldlt(int n, const S* factors, S* x);

}  // namespace conddp
