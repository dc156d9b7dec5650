#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"
#include "solvers/linalg/riccati_equation.hpp"

namespace conddp {

/// Removes rounding from a symmetric matrix that is positive semidefinite up to rounding. Rows and
/// directions that are zero, after scaling the diagonal to ones, become exactly zero. A positive
/// definite matrix is returned unchanged.
Eigen::MatrixXd without_rounding(const Eigen::MatrixXd& matrix);

/// The ellipsoid yᵀP y ≤ 1 of a positive semidefinite P; unbounded along the null space of P.
struct TerminalEllipsoid {
  Eigen::MatrixXd axes;  ///< y = axes·s has yᵀP y = ‖s‖²; the number of columns is the rank of P
  Eigen::MatrixXd free;  ///< orthonormal basis of the null space of P
};

TerminalEllipsoid terminal_ellipsoid(const Eigen::MatrixXd& P);

/// Terminal ingredients at an equilibrium (x̄, ū) of a knot that is repeated forever. They are the
/// cost-to-go ½ (x ⊖ x̄)ᵀP(x ⊖ x̄) of the linear-quadratic regulator, and its control ū − K (x ⊖
/// x̄).
///
/// Held contacts restrict the states of a robot to their tangent space, J δq = 0 and J δv = 0. The
/// regulator acts in the coordinates y of that space, x ⊖ x̄ = T y; P and K are zero across it.
/// Integrals are across it, too: no cost depends on them, so their values do not count.
struct TerminalIngredients {
  std::shared_ptr<const ShootingProblem> knot;  ///< the knot alone, starting at x̄
  std::vector<double> x;                        ///< nx
  Eigen::VectorXd u;                            ///< nu
  double drift = 0;          ///< largest entry of (f(x̄, ū) ⊖ x̄) / dt, which is rounding
  double cost = 0;           ///< cost of the knot at (x̄, ū)
  Eigen::VectorXd gradient;  ///< nz: gradient of the knot's cost there
  /// T: ndx x m, orthonormal columns; columns of the identity without contacts.
  Eigen::MatrixXd tangent;
  RegulatorProblem linear;  ///< in y: linear map of the knot and exact Hessian of its cost
  Regulator regulator;      ///< in y
  Eigen::MatrixXd P, K;     ///< ndx x ndx, nu x ndx
};

/// Ingredients, or a message and a hint on why they do not exist.
struct TerminalResult {
  std::optional<TerminalIngredients> ingredients;
  std::string fault, hint;
};

/// Start of the search for an equilibrium: a knot of a phase, a state (nx numbers of the knot's
/// model) and a control.
struct EquilibriumGuess {
  const Phase& phase;
  int knot;
  std::vector<double> x;
  Eigen::VectorXd u;
};

/// Adjusts the control until the knot stays at its state, and solves for the regulator there.
/// Remembered controls take the value found. `names` are those of tangent vectors, for messages.
TerminalResult find_terminal_ingredients(const EquilibriumGuess& guess,
                                         const std::vector<std::string>& names);

}  // namespace conddp
