#pragma once

#include <Eigen/Core>

#include "ocp/problem/trajectory.hpp"
#include "spatial/aligned.hpp"
#include "spatial/dual.hpp"
#include "systems/state_manifold.hpp"

namespace conddp {

/// Coordinates w of states near a center c: x = c ⊕ w, w = x ⊖ c (ndx numbers). On flat parts the
/// center is zero, so that coordinates equal the state. Curved parts have exponential coordinates,
/// valid for rotations by less than π.
///
/// Evaluators give all derivatives in tangent vectors δx at a state. With coordinates, δx = R δw: R
/// is the right Jacobian of exp in the block of each curved segment, and the identity on flat
/// parts.
class StateChart {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

  explicit StateChart(const StateManifold& manifold);

  /// Moves the center of the curved parts to a state.
  void set_center(const Eigen::Ref<const Eigen::VectorXd>& x);
  /// x = c ⊕ w.
  void state(const double* w, Eigen::Ref<Eigen::VectorXd> x) const;
  /// w = x ⊖ c.
  void coordinates(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Ref<Eigen::VectorXd> w) const;

  /// Prepares R and R⁻¹ at coordinates w.
  void set_point(const Eigen::Ref<const Eigen::VectorXd>& w);
  /// v ← Rᵀ v: converts a gradient from tangent vectors to coordinates.
  void pull(Eigen::Ref<Eigen::VectorXd> v) const;
  /// M ← M R, for the first ndx columns of a derivative in tangent vectors.
  void pull_columns(Eigen::Ref<Eigen::MatrixXd> M) const;
  /// H ← Pᵀ H P with P = blockdiag(R, I).
  void pull_hessian(Eigen::Ref<Eigen::MatrixXd> H) const;
  /// M ← R⁻¹ M, for rows that are tangent vectors at the state.
  void push_rows(Eigen::Ref<Eigen::MatrixXd> M) const;
  /// v ← R⁻ᵀ v.
  void push_transposed(Eigen::Ref<Eigen::VectorXd> v) const;
  /// H += ∂²(gᵀ (x(w) ⊖ x)) / ∂w²: curvature of the chart, where g is a gradient in tangent
  /// vectors.
  void add_curvature(const Eigen::Ref<const Eigen::VectorXd>& g, Eigen::Ref<Eigen::MatrixXd> H);
  /// Second derivative of μᵀ w(x) in tangent vectors at x, for one curved segment (n x n in the top
  /// left). It is the curvature that coordinates add to the image of the dynamics.
  const Matrix6& coordinate_curvature(int segment, const Eigen::Ref<const Eigen::VectorXd>& mu);

  /// Largest rotation of a curved part from its center, rad.
  double angle(const Eigen::Ref<const Eigen::VectorXd>& w) const;

 private:
  const StateManifold& manifold_;
  Eigen::VectorXd center_;
  Eigen::VectorXd w_;
  AlignedVector<double> jacobian_, inverse_, scratch_;  ///< R and R⁻¹, row-major blocks
  AlignedVector<Dual<double>> dual_w_, dual_a_, dual_b_;
  Matrix6 curvature_;
};

}  // namespace conddp
