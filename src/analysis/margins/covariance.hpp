#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/evaluation/linearization.hpp"

namespace conddp {

/// Independent normal noise on states: standard deviations of the tangent coordinates, ndx numbers
/// each, in their units.
struct StateNoise {
  Eigen::VectorXd initial;      ///< on the state at the start of the first knot that takes time
  Eigen::VectorXd process;      ///< added to the state by each knot that takes time
  Eigen::VectorXd measurement;  ///< added to the state that the gains use in each of these knots
};

/// First knot that takes time, or N. Earlier knots (the choice of an initial state, an impulse)
/// belong to the start.
int first_timed_knot(const ShootingProblem& problem);

/// Covariances of the states x_k ⊖ x̄_k, ndx x ndx per node, under the controls ū_k + K_k (x ⊖ x̄_k
/// + measurement noise). First order about the trajectory of the linearization: P⁺ = (A + B K) P (A
/// + B K)ᵀ + B K N (B K)ᵀ + W. Bounds do not clamp these controls. Zero before the first knot that
/// takes time.
std::vector<Eigen::MatrixXd> propagate_covariance(const ShootingProblem& problem,
                                                  const Linearization& linear,
                                                  const std::vector<Eigen::MatrixXd>& gains,
                                                  const StateNoise& noise);

}  // namespace conddp
