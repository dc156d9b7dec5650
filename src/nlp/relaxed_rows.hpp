#pragma once

#include <Eigen/Core>

namespace conddp {

/// A second-order cone ‖v‖ ≤ t as one row h(g) ≥ 0 of a nonlinear program, g = (v, t):
///
///   surface:   h = √2 t − √(‖v‖² + t² + ε²) + ε,
///   distance:  h = t − √(‖v‖² + ε²) + ε.
///
/// Both are concave, have a gradient everywhere and relax the cone by ε at most. With ε = 0, both
/// vanish only on the surface of the cone. There the gradient of `surface` is the unit normal; it
/// is smooth wherever t > 0. In `distance`, −h is √2 times the distance from the cone wherever the
/// nearest point is not its tip. It has a kink along the whole axis v = 0, where its curvature is
/// 1/ε.
struct ConeRow {
  enum class Form { surface, distance };
  Form form = Form::surface;
  double smoothing = 0;  ///< ε, in the unit of t

  /// h at g (n numbers), and its derivative if `slope` is not null. A multiplier η ≤ 0 of h
  /// represents the vector η ∇h, which lies in the polar cone.
  double value(const double* g, int n, double* slope) const;
  /// H += weight Cᵀ ∇²h C, where C is the derivative of g, with a row for each number of g.
  void add_curvature(const Eigen::Ref<const Eigen::VectorXd>& g,
                     const Eigen::Ref<const Eigen::MatrixXd>& C, double weight,
                     Eigen::Ref<Eigen::MatrixXd> H) const;
  /// Multiplier η of h such that η ∇h on the surface is a vector ν (n numbers) of the polar cone.
  /// At the tip, η ∇h may be longer than ν, by a factor of √2 at most.
  double multiplier(const double* nu, int n) const;

 private:
  /// Number of rows under the norm in h, (v, t) or (v, 0).
  int norm_rows(int n) const { return form == Form::surface ? n : n - 1; }
  double root(const double* g, int n) const;
};

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
