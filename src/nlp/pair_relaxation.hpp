#pragma once

#include <Eigen/Core>

namespace conddp {

/// Relaxations of complementary pairs 0 ≤ z ⊥ s ≥ 0 to smooth rows of a nonlinear program, with an
/// ε > 0 that a sequence of solves lowers:
/// - elementwise: z s ≤ ε for each pair (Scholtes 2001);
/// - inner_product: Σ z s ≤ ε over the pairs of a node;
/// - fischer_burmeister: z + s − √(z² + s² + 2 ε) = 0 for each pair, so that z s = ε;
/// - penalty: no row, but Σ z s / ε in the objective.
enum class PairRelaxation { elementwise, inner_product, fischer_burmeister, penalty };

/// Value of a row at the pairs g = (z_0, s_0, …), `count` numbers, and its derivative if `slope` is
/// not null. For a penalty: Σ z s.
double pair_value(PairRelaxation relaxation, const double* g, int count, double epsilon,
                  double* slope);
/// Second derivatives of a row within one pair: ∂²/∂z², ∂²/∂z∂s, ∂²/∂s². All others are zero.
Eigen::Vector3d pair_curvature(PairRelaxation relaxation, double z, double s, double epsilon);

}  // namespace conddp
