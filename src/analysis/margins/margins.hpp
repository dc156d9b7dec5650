#pragma once

#include <string>
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

/// Covariances of the states x_k ⊖ x̄_k, ndx x ndx per node, under the controls ū_k + K_k (x ⊖ x̄_k
/// + measurement noise). First order about the trajectory of the linearization: P⁺ = (A + B K) P (A
/// + B K)ᵀ + B K N (B K)ᵀ + W. Bounds do not clamp these controls. Zero before the first knot that
/// takes time.
std::vector<Eigen::MatrixXd> propagate_covariance(const ShootingProblem& problem,
                                                  const Linearization& linear,
                                                  const std::vector<Eigen::MatrixXd>& gains,
                                                  const StateNoise& noise);

/// Distance of a quantity from its bound at a node, and its standard deviation under noise.
struct Margin {
  int knot = 0;         ///< N for the terminal node
  double distance = 0;  ///< from the bound, in the quantity's unit; negative outside
  double sigma = 0;     ///< standard deviation of the quantity, above 0

  /// The distance in standard deviations.
  double steps() const { return distance / sigma; }
  /// Probability that the bound is violated at this node, for a normal distribution.
  double probability() const;
};

/// One side of a bound along the trajectory: of a control, of a constraint row, or of a cone (its
/// axis minus its norm).
struct MarginCurve {
  std::string name;  ///< name of the control or constraint
  int row = -1;      ///< row of the constraint; −1 for controls and constraints with one row
  bool upper = true;
  std::vector<Margin> nodes;  ///< in order; at least one

  /// The node with the fewest standard deviations to the bound.
  const Margin& smallest() const;
};

/// Margins of all control bounds and of all constraints except equalities and complementary pairs.
/// The controls of the trajectory follow the gains under noise, to first order
/// (propagate_covariance). The smallest margins come first. If several contacts have a constraint,
/// each node counts the smallest margin. A node is left out if noise does not move the quantity
/// there, or if the plan holds it at its bound. Throws std::overflow_error if a covariance is not
/// finite.
std::vector<MarginCurve> constraint_margins(const ShootingProblem& problem,
                                            const Trajectory& trajectory,
                                            const std::vector<Eigen::MatrixXd>& gains,
                                            const StateNoise& noise);

}  // namespace conddp
