#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ocp/problem/problem.hpp"
#include "solvers/linalg/riccati_equation.hpp"

namespace conddp {

/// What a problem ends with at an equilibrium (x̄, ū) of one of its knots that is repeated for ever:
/// the cost-to-go ½ (x ⊖ x̄)ᵀP(x ⊖ x̄) of the linear-quadratic regulator, and its control
/// ū − K (x ⊖ x̄).
///
/// Held contacts leave a robot the states on their tangent space, J δq = 0 and J δv = 0. The
/// regulator is one of the coordinates y of that space, x ⊖ x̄ = T y; P and K are zero across it.
/// Integrals are across it, too: no cost depends on them, so that it does not count what they are.
struct TerminalIngredients {
  std::shared_ptr<const ShootingProblem> knot;  ///< the knot alone, from x̄ on
  std::vector<double> x;                        ///< nx
  Eigen::VectorXd u;                            ///< nu
  double drift = 0;          ///< largest entry of (f(x̄, ū) ⊖ x̄) / dt, which is rounding
  double cost = 0;           ///< of the knot at (x̄, ū)
  Eigen::VectorXd gradient;  ///< nz: of the knot's cost there
  Eigen::MatrixXd
      tangent;  ///< T: ndx x m, orthonormal columns; columns of the identity without contacts
  RegulatorProblem linear;  ///< of y: the knot's linear map and its cost's exact Hessian
  Regulator regulator;      ///< of y
  Eigen::MatrixXd P, K;     ///< ndx x ndx, nu x ndx
};

/// Ingredients, or why there are none, in words, with a hint.
struct TerminalResult {
  std::optional<TerminalIngredients> ingredients;
  std::string fault, hint;
};

/// Where an equilibrium is looked for: a knot of a phase, a state (nx numbers of the knot's model)
/// and a control to start from.
struct EquilibriumGuess {
  const Phase& phase;
  int knot;
  std::vector<double> x;
  Eigen::VectorXd u;
};

/// Moves the control until the knot stays where it is, and solves for the regulator there. A
/// remembered control becomes the one found. `names` are those of tangent vectors, for messages.
TerminalResult find_terminal_ingredients(const EquilibriumGuess& guess,
                                         const std::vector<std::string>& names);

}  // namespace conddp
