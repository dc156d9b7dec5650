#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "solvers/stages/value_function.hpp"

namespace conddp {

/// Effect of an open gap f̄ = f(x_k, u_k) ⊖ x_{k+1} in the linear model of the next node.
///
/// The rollout contracts gaps by x⁺ = f ⊕ (α − 1) f̄, so that to first order δx_{k+1} = G δf + α f̄.
/// Tangent vectors at f and at x_{k+1} differ on curved spaces: G = Ad exp(f̄). G is the identity if
/// the space is flat or the gap is closed. A gap of rounding size is treated as closed.
class GapTransport {
 public:
  explicit GapTransport(const StateManifold& manifold);

  /// Prepares G for this gap (ndx).
  void set(const Eigen::Ref<const Eigen::VectorXd>& gap);
  /// Closes the gap.
  void close() { none_ = identity_ = true; }
  bool closed() const { return none_; }

  /// δ ← G δ + f̄.
  void push(Eigen::Ref<Eigen::VectorXd> delta) const;
  /// λ ← Gᵀ λ.
  void pull(Eigen::Ref<Eigen::VectorXd> lambda) const;
  /// Pulls the value at x_{k+1} back to a function of δf at a full step: V_x ← Gᵀ (V_x + V_xx f̄),
  /// V_xx ← Gᵀ V_xx G.
  void pull(ValueFunction& value) const;
  /// `Vx` ← the gradient of the value pulled back in this way.
  void pull_gradient(const ValueFunction& value, Eigen::Ref<Eigen::VectorXd> Vx) const;
  /// True if G is the identity.
  bool flat() const { return identity_; }
  /// G on a curved segment of n coordinates, n x n and row-major.
  const double* block(std::size_t segment) const {
    return G_.data() + segment * StateManifold::kBlockSize;
  }

 private:
  const StateManifold& manifold_;
  bool none_ = true, identity_ = true;
  Eigen::VectorXd gap_, minus_gap_;
  std::vector<double> G_, wrt_dx_;  // row-major blocks, StateManifold::kBlockSize apart
};

/// The gaps of all knots of a linearized iterate.
class Gaps {
 public:
  explicit Gaps(const ShootingProblem& problem);

  /// Takes the gaps of a linearization. If a solver keeps its gaps closed, `open` is false and all
  /// gaps close.
  void set(const Linearization& linearization, bool open);
  /// Takes these gaps (ndx x N).
  void set(const Eigen::MatrixXd& gap);
  const GapTransport& operator[](int k) const { return knots_[k]; }
  /// Σ‖gap‖₁; 0 if all gaps are closed.
  double norm() const { return norm_; }
  bool closed() const { return norm_ == 0; }

 private:
  std::vector<GapTransport> knots_;
  double norm_ = 0;
};

}  // namespace conddp
