#pragma once

#include <Eigen/Core>

#include "ocp/problem/trajectory.hpp"
#include "spatial/aligned.hpp"
#include "spatial/dual.hpp"
#include "systems/state_manifold.hpp"

namespace conddp {

/// Coordinates w of the states near a centre c: x = c ⊕ w, w = x ⊖ c (ndx numbers). On flat parts
/// the centre is zero, so that their coordinates are the state itself; curved parts have
/// exponential coordinates, good for rotations by less than π.
///
/// Tangent vectors at a state, in which an evaluator gives all derivatives, follow from coordinates
/// by δx = R δw, with a block per curved segment that is the right Jacobian of exp, and the
/// identity on flat parts.
class StateChart {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

  explicit StateChart(const StateManifold& manifold);

  /// Moves the centre of the curved parts to a state.
  void set_center(const Eigen::Ref<const Eigen::VectorXd>& x);
  /// x = c ⊕ w.
  void state(const double* w, Eigen::Ref<Eigen::VectorXd> x) const;
  /// w = x ⊖ c.
  void coordinates(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Ref<Eigen::VectorXd> w) const;

  /// Prepares R and R⁻¹ at coordinates w.
  void set_point(const Eigen::Ref<const Eigen::VectorXd>& w);
  /// v ← Rᵀ v, from a gradient by tangent vectors to one by coordinates.
  void pull(Eigen::Ref<Eigen::VectorXd> v) const;
  /// M ← M R, for the first ndx columns of a derivative by tangent vectors.
  void pull_columns(Eigen::Ref<Eigen::MatrixXd> M) const;
  /// H ← Pᵀ H P with P = blockdiag(R, I).
  void pull_hessian(Eigen::Ref<Eigen::MatrixXd> H) const;
  /// M ← R⁻¹ M, for rows that are tangent vectors at the state.
  void push_rows(Eigen::Ref<Eigen::MatrixXd> M) const;
  /// v ← R⁻ᵀ v.
  void push_transposed(Eigen::Ref<Eigen::VectorXd> v) const;
  /// H += ∂²(gᵀ (x(w) ⊖ x)) / ∂w²: the curvature of the chart, where g is a gradient by tangent
  /// vectors.
  void add_curvature(const Eigen::Ref<const Eigen::VectorXd>& g, Eigen::Ref<Eigen::MatrixXd> H);
  /// The second derivative of μᵀ w(x) by tangent vectors at x, block by block (n x n in the top
  /// left): what makes coordinates of the dynamics' image curved.
  const Matrix6& coordinate_curvature(int segment, const Eigen::Ref<const Eigen::VectorXd>& mu);

  /// Largest rotation of a curved part from its centre, rad.
  double angle(const Eigen::Ref<const Eigen::VectorXd>& w) const;

 private:
  const StateManifold& manifold_;
  Eigen::VectorXd center_;
  Eigen::VectorXd w_;
  AlignedVector<double> jacobian_, inverse_, scratch_;  ///< R and R⁻¹, blocks by rows
  AlignedVector<Dual<double>> dual_w_, dual_a_, dual_b_;
  Matrix6 curvature_;
};

}  // namespace conddp
