#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "ocp/acts.hpp"
#include "solvers/options.hpp"

namespace conddp {

/// A statement of an answer about itself, and what was found instead.
struct Check {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::string name;  ///< "gap", "cost effort", "status", ...
  bool holds = true;
  double claimed = kNone;    ///< not a number where there is no claim in figures
  double found = kNone;      ///< the same quantity, computed anew
  double tolerance = kNone;  ///< by which the two may differ
  std::string place;         ///< "knot 12 (phase 'swing'), v/elbow", empty where it has none
  std::string message;       ///< what does not hold, empty where the figures say it
};

/// All that an answer states, in numbers; what it leaves open is not a number.
struct SolutionClaims {
  explicit SolutionClaims(const ShootingProblem& problem);

  Trajectory trajectory;
  std::vector<double> times;  ///< N + 1
  bool converged = false;
  std::string status;
  double cost = Check::kNone;
  std::vector<std::pair<std::string, double>> cost_by_name;
  double stationarity = Check::kNone;
  double gap = Check::kNone;
  double constraint = Check::kNone;
  double complementarity = Check::kNone;
  SolverOptions::Tolerances tolerances;
  Eigen::MatrixXd costates;        ///< ndx x (N + 1)
  Eigen::MatrixXd state_gradient;  ///< ndx x (N + 1): ∇_x of the Lagrangian
  /// Multipliers of the control bounds, one vector a knot; zero where the answer has none.
  std::vector<Eigen::VectorXd> lower_multipliers, upper_multipliers;
  /// Multipliers of the constraints, one a constraint row of the problem.
  Eigen::VectorXd multipliers;
  std::vector<Eigen::MatrixXd> gains;  ///< K, nu x ndx, one a knot
  /// How places are called.
  std::vector<std::string> tangent_names, control_names;
};

/// The statements of an answer that were checked; it holds where all of them do.
struct Certificate {
  std::vector<Check> checks;

  bool holds() const;
  int failures() const;
};

/// Judges an answer to a problem: evaluates every knot in scalar arithmetic, compares costs, gaps,
/// bounds and multipliers with what is claimed, and the gradient of the Lagrangian by dual numbers
/// (lagrangian_gradient). Nothing of the solvers has a part in it. docs/verification.md has the
/// formulas and tolerances.
Certificate certify(const ShootingProblem& problem, const SolutionClaims& claims);

/// "knot 12 (phase 'swing'), v/elbow"; the last part only where there is a name.
std::string place_text(const ShootingProblem& problem, int knot, const std::string& quantity);

}  // namespace conddp
