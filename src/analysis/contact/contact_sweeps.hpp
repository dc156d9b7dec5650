#pragma once

#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Projects f on the Euclidean disc ‖f‖ ≤ radius, or on the pyramid's section |f₁| + |f₂| ≤ radius.
Eigen::Vector2d nearest_friction(const Eigen::Vector2d& f, double radius, bool pyramid);

/// A unilateral row of a linearized step, or a group of friction rows, by row indices. Friction is
/// bounded by μ times the impulse of a normal row, or by a constant.
struct ImpulseBound {
  int normal = -1;      ///< row of an impulse ≥ 0 against a velocity ≥ 0; −1: none
  int tangent = -1;     ///< first row of friction; −1: none
  int tangents = 0;     ///< 1 or 2
  double friction = 0;  ///< μ
  double constant = 0;  ///< N s or N m s, without a normal row
  bool pyramid = false;
};

/// Finds impulses p with velocities u = u₀ + D p such that 0 ≤ p_n ⊥ u_n ≥ 0. Friction impulses p_t
/// are the projection of p_t − ρ u_t on their bound (maximal dissipation). Uses projected
/// Gauss-Seidel sweeps from p, which is overwritten (Jourdan, Alart, Jean 1998). The sweeps are
/// slow, but reliable for friction cones with dependent rows. Returns the last change, relative to
/// `scale`.
double sweep_impulses(const Eigen::MatrixXd& D, const Eigen::VectorXd& u0,
                      const std::vector<ImpulseBound>& bounds, double scale, Eigen::VectorXd& p);

/// Residual of these conditions: the largest |p − nearest(p − u)|, impulses divided by `scale`.
double impulse_residual(const Eigen::VectorXd& u, const std::vector<ImpulseBound>& bounds,
                        double scale, const Eigen::VectorXd& p);

}  // namespace conddp
