#pragma once

#include <Eigen/Core>

namespace conddp {

/// A second-order cone ‖v‖ ≤ t as one row h(g) ≥ 0 of a nonlinear program, g = (v, t):
///
///   surface:   h = √2 t − √(‖v‖² + t² + ε²) + ε,
///   distance:  h = t − √(‖v‖² + ε²) + ε.
///
/// Both are concave, never without a gradient and weaker by ε at most. With ε = 0 both vanish on
/// the surface of the cone alone. There the gradient of `surface` is the unit normal, and it is
/// smooth wherever t > 0; in `distance`, −h is √2 times the distance from the cone wherever the
/// nearest point is not its tip, and has a kink along all of the axis v = 0, where its curvature is
/// 1/ε.
struct ConeRow {
  enum class Form { surface, distance };
  Form form = Form::surface;
  double smoothing = 0;  ///< ε, in the unit of t

  /// h at g, n numbers, and its derivative where asked for. A multiplier η ≤ 0 of h stands for the
  /// vector η ∇h, which is in the polar cone.
  double value(const double* g, int n, double* slope) const;
  /// H += weight Cᵀ ∇²h C, where C, with a row for each number of g, is the derivative of g.
  void add_curvature(const Eigen::Ref<const Eigen::VectorXd>& g,
                     const Eigen::Ref<const Eigen::MatrixXd>& C, double weight,
                     Eigen::Ref<Eigen::MatrixXd> H) const;
  /// The multiplier of h for which η ∇h on the surface is a vector ν, of n numbers, in its polar
  /// cone; at the tip η ∇h may be longer than ν, by √2 at most.
  double multiplier(const double* nu, int n) const;

 private:
  /// (v, t) or (v, 0): of what h subtracts the norm.
  int norm_rows(int n) const { return form == Form::surface ? n : n - 1; }
  double root(const double* g, int n) const;
};

}  // namespace conddp
