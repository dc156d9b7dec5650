#pragma once

#include <Eigen/Dense>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/riccati/linear_rollout.hpp"

namespace conddp {

/// Lengths up to which a step keeps slacks (primal) and multipliers (dual) inside their sets.
struct StepLimits {
  double primal = 1, dual = 1;
};

/// A second-order cone of a primal-dual interior-point method: g + p = s, with s and the multiplier
/// ν = μ s⁻¹ in the cone (the inverse is that of its Jordan algebra). A hard cone has p = 0, a cone
/// that is soft by its distance with the weight w has p = 2 μ ν / (w² − ‖ν‖²). The scaling of
/// Nesterov and Todd eliminates s and p and leaves D δν = push − C δz.
class InteriorCone {
 public:
  explicit InteriorCone(const NodeConstraint& constraint);

  int node() const { return constraint_->node; }
  /// Sets slack and multiplier at the values of all constraint rows of the problem. The slack keeps
  /// the distance `inside` from the boundary, relative to its size.
  void start(const Eigen::VectorXd& rows, double mu, double inside);
  /// Computes the residual g + p − s.
  void measure(const Eigen::VectorXd& rows);
  /// Subtracts ν from the multipliers of its rows.
  void write_multipliers(Eigen::VectorXd& multipliers) const;
  /// Adds −Cᵀ D⁻¹ push to the gradient of the node.
  void add_gradient(const ShootingProblem& problem, double mu, Linearization& to);
  /// Adds the lower triangle of Cᵀ D⁻¹ C.
  void add_hessian(const ShootingProblem& problem, const Linearization& linearization,
                   Eigen::MatrixXd& to);
  /// Computes the steps of s, ν and p, and shortens the limits so that `left` of each distance from
  /// the boundary is left.
  void expand(const ShootingProblem& problem, const Linearization& linearization,
              const LinearRollout& step, double left, StepLimits& limits);
  /// Derivative of the barrier function along the step, beyond that of the Lagrangian.
  double barrier_slope(double mu) const;
  double barrier_function(double mu) const;
  void save() { saved_s_ = s_, saved_p_ = p_; }
  void restore() { s_ = saved_s_, p_ = saved_p_; }
  void move(double length);
  void accept(double dual) { nu_ += dual * dnu_; }
  double infeasibility(const Eigen::VectorXd& rows) const;
  double largest_residual() const;
  /// Largest residual of s ∘ ν = μ e.
  double off_center(double mu) const;
  double multiplier_sum() const { return nu_.lpNorm<1>(); }

 private:
  bool is_soft() const;
  auto values(const Eigen::VectorXd& rows) const { return rows.segment(constraint_->row, n_); }
  void find_elastic_dual(double mu) const;
  void scale(double mu);

  const NodeConstraint* constraint_;
  int n_;
  Eigen::VectorXd s_, nu_, p_, saved_s_, saved_p_, residual_, push_, along_, ds_, dnu_, dp_;
  Eigen::VectorXd off_;          ///< p(ν) − p
  Eigen::MatrixXd P_, inverse_;  ///< ∂p/∂ν, D⁻¹
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::MatrixXd product_;  ///< D⁻¹ C
  mutable Eigen::VectorXd work_;
};

}  // namespace conddp
