#pragma once

#include <vector>

#include "solvers/stages/stage_sweep.hpp"

namespace conddp {

/// Consecutive knots of a horizon, swept from an end value that is known up to a linear term θ. The
/// term remains as a parameter (Wright 1991; Jallet, Dantec, Arlaud, Carpentier, Mansard 2024):
///   V(x, θ) = ½ xᵀ P x + pᵀ x + xᵀ L θ + sᵀ θ + ½ θᵀ S θ + constant, at the end ½ xᵀ W x + θᵀ x,
///   δu = k + K δx + K_θ θ, with K_θ = −Q_uu⁻¹ B and B = f_uᵀ L⁺ where the control is free,
///   L = f_xᵀ L⁺ + Kᵀ B, s = s⁺ + Bᵀ k, S = S⁺ + Bᵀ K_θ.
/// The step at the end of the segment is ∂V/∂θ = Lᵀ δx + s + S θ. W is any symmetric matrix; the
/// nearer it is to that of the true value, the nearer K is to the true gains.
class ParametricSegment {
 public:
  /// Covers the knots first … last − 1. θ is applied to them in `parts` parts.
  ParametricSegment(const ShootingProblem& problem, int index, int first, int last, int parts);

  int first() const { return first_; }
  int last() const { return last_; }
  /// W (ndx x ndx).
  Eigen::MatrixXd& end_weight() { return end_.Vxx; }

  /// Fills values, Q_uu and feedback of the segment's knots for θ = 0. False if a stage is not
  /// finite or lacks a minimum.
  bool sweep(const SweptHorizon& horizon, StageSolver& stages, Feedback& feedback,
             std::vector<ValueFunction>& values, std::vector<Eigen::MatrixXd>& Quu);
  /// Lᵀ (ndx x ndx), s, and S in its lower triangle, at the first node.
  LaneMatrix& Lt() { return Lt_.front(); }
  const Eigen::VectorXd& s() const { return s_; }
  const LaneMatrix& S() const { return S_; }

  /// Adds the linear terms of values, policy and feedback for this θ in one part of the knots. To
  /// be called after a sweep; parts may run in parallel.
  void apply(int part, const SweptHorizon& horizon, const Eigen::VectorXd& theta,
             ActiveSet& active_set, Feedback& feedback, std::vector<ValueFunction>& values);

 private:
  struct Scratch {
    Eigen::VectorXd costate, gradient, product;
  };

  void pull_parameters(const SweptHorizon& horizon, int k);
  bool solve(const SweptHorizon& horizon, int k, StageSolver& stages, Feedback& feedback);
  void form_parameters(int k, const Eigen::VectorXd& feedforward);

  int index_, first_, last_, ndx_, row_;
  StageSweep stage_;
  ValueFunction end_;
  std::vector<LaneMatrix> Lt_;            ///< at each node
  std::vector<Eigen::MatrixXd> Kt_;       ///< K_θ transposed (ndx x nu), at each knot
  LaneMatrix S_, Zt_, pulled_, columns_;  ///< Zt: (f_x f_u)ᵀ L⁺ transposed, ndx x nz
  LaneMatrix stacked_;                    ///< linear terms of a stage, in the state and in θ
  Eigen::VectorXd s_;
  std::vector<Scratch> scratch_;  ///< one per part
};

}  // namespace conddp
