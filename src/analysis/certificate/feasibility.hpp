#pragma once

#include <cmath>

#include <Eigen/Core>

#include "analysis/certificate/solution_claims.hpp"

namespace conddp {

/// The largest of some quantities, and its place.
struct Worst {
  double value = 0;
  double size = 0;  ///< size of its terms
  int knot = -1;
  int entry = -1;

  /// NaN counts as the largest, and loses its sign.
  void meet(double candidate, double candidate_size, int k, int i) {
    if (std::isnan(value) || !(std::isnan(candidate) || candidate > value)) return;
    *this = {std::abs(candidate), std::abs(candidate_size), k, i};
  }
};

/// Violations of bounds and constraints by an answer, and multipliers that do not match them.
struct Feasibility {
  Worst violation;  ///< distance from a set
  Worst product;    ///< multiplier times distance from its bound; infinite without a bound
  Worst negative;   ///< distance of a multiplier from its set's normal cone, which must be zero
};

/// (v, t) minus the nearest point of the second-order cone ‖v‖ ≤ t.
Eigen::VectorXd beyond_cone(const Eigen::VectorXd& s);

/// Measures the feasibility of an answer. Worst::entry is the index of a control for its bounds;
/// for a constraint, constraint_of returns the index in the problem. `values` are g of all
/// constraint rows.
Feasibility measure_feasibility(const ShootingProblem& problem, const SolutionClaims& claims,
                                const Eigen::VectorXd& values);
/// Index of the constraint in the problem, or −1 if `worst` does not belong to a constraint.
int constraint_of(const Worst& worst);

}  // namespace conddp
