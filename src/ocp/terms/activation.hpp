#pragma once

#include <vector>

#include "spatial/dual.hpp"

namespace conddp {

/// Map from a residual r to a scalar a(r). With component weights w (all 1 if empty):
/// - quadratic:         ½ Σ wᵢ rᵢ²
/// - quadratic_barrier: ½ Σ wᵢ (min(rᵢ − lowerᵢ, 0)² + max(rᵢ − upperᵢ, 0)²)
/// - smooth_l1:         Σ wᵢ (√(rᵢ² + ε²) − ε)
/// - smooth_l2:         √(Σ wᵢ rᵢ² + ε²) − ε
/// - linear:            Σ wᵢ rᵢ
/// The smooth norms subtract ε so that a zero residual costs nothing.
enum class ActivationKind { quadratic, quadratic_barrier, smooth_l1, smooth_l2, linear };

struct Activation {
  ActivationKind kind = ActivationKind::quadratic;
  std::vector<double> weights;  ///< per component, or empty
  std::vector<double> lower;    ///< of the barrier, −∞ if unbounded
  std::vector<double> upper;    ///< of the barrier, +∞ if unbounded
  double epsilon = 0.1;         ///< of the smooth norms, in the residual's unit

  /// a(r) for a residual of n rows.
  template <class S>
  S value(const S* r, int n) const;
  /// a(r) with its gradient g and Hessian diag(diagonal) + rank_one · g gᵀ; rank_one is 0 except
  /// for smooth_l2.
  template <class S>
  S differentiate(const S* r, int n, S* gradient, S* diagonal, S& rank_one) const;

 private:
  double weight(int i) const { return weights.empty() ? 1.0 : weights[i]; }
  /// Σ wᵢ rᵢ².
  template <class S>
  S weighted_square(const S* r, int n) const;
  template <class S>
  S differentiate_quadratic(const S* r, int n, S* gradient, S* diagonal) const;
  template <class S>
  S differentiate_barrier(const S* r, int n, S* gradient, S* diagonal) const;
  template <class S>
  S differentiate_smooth_l1(const S* r, int n, S* gradient, S* diagonal) const;
  template <class S>
  S differentiate_smooth_l2(const S* r, int n, S* gradient, S* diagonal, S& rank_one) const;
  template <class S>
  S differentiate_linear(const S* r, int n, S* gradient, S* diagonal) const;
};

}  // namespace conddp
