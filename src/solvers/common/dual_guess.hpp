#pragma once

#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Multipliers to start from, of a former answer, in the conventions of SolveResult.
struct DualGuess {
  Eigen::VectorXd constraints;  ///< one a constraint row of the problem; 0 where none is known
  /// ndx x (N + 1), or empty where they are not known; only `ipopt` starts from them.
  Eigen::MatrixXd costates;
  /// ∇_u of the Lagrangian without the bounds' terms, one a knot; empty where not known.
  std::vector<Eigen::VectorXd> control_gradient;
};

}  // namespace conddp
