#pragma once

#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Initial multipliers from a former answer, in the conventions of SolveResult.
struct DualGuess {
  Eigen::VectorXd constraints;  ///< by constraint row of the problem; 0 if unknown
  /// ndx x (N + 1), empty if unknown. Only `ipopt` starts from them.
  Eigen::MatrixXd costates;
  /// ∇_u of the Lagrangian without the bounds' terms, by knot; empty if unknown.
  std::vector<Eigen::VectorXd> control_gradient;
};

}  // namespace conddp
