#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solvers/common/options.hpp"
#include "support/linear_quadratic.hpp"

/// Constraints on the problems of small_problems.hpp and linear_quadratic.hpp, and published cases
/// with constraints.
namespace conddp::testing {

/// A constraint on the nodes first … last (N is the terminal node) with equal numbers, except for
/// references given per node.
struct Added {
  std::string name;
  std::shared_ptr<const Residual> residual;
  ConstraintKind kind = ConstraintKind::bounds;
  std::vector<double> reference, lower, upper;
  int first = 0, last = 0;
  double slope = 1;
  Softness softness = Softness::hard;
  double weight = 0;                                 ///< of a soft constraint
  std::vector<std::vector<double>> references = {};  ///< per node, instead of one
};

/// Tolerances tight enough that answers of two solvers differ only by rounding.
SolverOptions tight_options();

/// The problem with additional constraints.
ShootingProblem with_constraints(const ShootingProblem& problem, const std::vector<Added>& list);

/// x_N = goal.
Added goal_constraint(const ShootingProblem& problem, std::vector<double> goal);

/// ALTRO's cases (Howell, Jackson, Manchester 2019) with their optimal costs.
struct PublishedCase {
  std::string name;
  ShootingProblem problem;
  double control;  ///< of the guess
  double cost;
};

/// In the order of the paper.
std::vector<PublishedCase> published_cases();

}  // namespace conddp::testing
