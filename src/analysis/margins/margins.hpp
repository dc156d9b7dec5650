#pragma once

#include <string>
#include <vector>

#include "analysis/margins/covariance.hpp"

namespace conddp {

/// How far a quantity is from its bound at a node, and how much noise moves it.
struct Margin {
  int knot = 0;         ///< N: the terminal node
  double distance = 0;  ///< from the bound, in the quantity's unit; negative outside
  double sigma = 0;     ///< standard deviation of the quantity, above 0

  /// The distance in standard deviations.
  double steps() const { return distance / sigma; }
  /// How likely the bound is violated at this node, by the normal law.
  double probability() const;
};

/// One side of a bound, along the trajectory: of a control, of a row of a constraint, or of how far
/// the norm of a cone is from its axis.
struct MarginCurve {
  std::string name;  ///< of the control or constraint
  int row = -1;      ///< of the constraint; −1: of a control, or of a constraint with one row
  bool upper = true;
  std::vector<Margin> nodes;  ///< in order; at least one

  /// The node at which the bound is the fewest standard deviations away.
  const Margin& smallest() const;
};

/// Margins of all bounds on controls and of all constraints but equalities and pairs that are
/// complementary, at a trajectory whose controls follow the gains under noise, to first order
/// (propagate_covariance). Those with the smallest margins come first. Where several contacts
/// have a constraint, a node counts the smallest margin. Nodes at which noise does not move a
/// quantity are left out, and those at which the plan holds it at its bound. Throws
/// std::overflow_error where a covariance is not finite.
std::vector<MarginCurve> constraint_margins(const ShootingProblem& problem,
                                            const Trajectory& trajectory,
                                            const std::vector<Eigen::MatrixXd>& gains,
                                            const StateNoise& noise);

}  // namespace conddp
