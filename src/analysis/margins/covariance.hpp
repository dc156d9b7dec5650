#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/evaluation/linearization.hpp"

namespace conddp {

/// Independent normal noise on states: standard deviations of the tangent coordinates, ndx numbers
/// each, in their units.
struct StateNoise {
  Eigen::VectorXd initial;      ///< of the state in which the first knot that takes time begins
  Eigen::VectorXd process;      ///< added to the state by each knot that takes time
  Eigen::VectorXd measurement;  ///< added to what the gains get to see of it in each of them
};

/// The first knot that takes time; N where there is none. What comes before it (the choice of an
/// initial state, an impulse) belongs to the start.
int first_timed_knot(const ShootingProblem& problem);

/// Covariances of the states, x_k ⊖ x̄_k, ndx x ndx, one a node, where controls are
/// ū_k + K_k (x ⊖ x̄_k + measurement noise), to first order about the trajectory of the
/// linearization: P⁺ = (A + B K) P (A + B K)ᵀ + B K N (B K)ᵀ + W. Bounds do not clamp the controls
/// of this law. Zero before the first knot that takes time.
std::vector<Eigen::MatrixXd> propagate_covariance(const ShootingProblem& problem,
                                                  const Linearization& linear,
                                                  const std::vector<Eigen::MatrixXd>& gains,
                                                  const StateNoise& noise);

}  // namespace conddp
