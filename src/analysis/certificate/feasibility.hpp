#pragma once

#include <cmath>

#include <Eigen/Core>

#include "analysis/certificate/solution_claims.hpp"

namespace conddp {

/// The largest of some quantities and where it is.
struct Worst {
  double value = 0;
  double size = 0;  ///< of its terms
  int knot = -1;
  int entry = -1;

  /// Not-a-number counts as the largest, and has no sign.
  void meet(double candidate, double candidate_size, int k, int i) {
    if (std::isnan(value) || !(std::isnan(candidate) || candidate > value)) return;
    *this = {std::abs(candidate), std::abs(candidate_size), k, i};
  }
};

/// How far an answer is from keeping its bounds and constraints, and its multipliers from belonging
/// to them.
struct Feasibility {
  Worst violation;  ///< distance from a set
  Worst product;    ///< multiplier times distance from its bound; infinite where there is no bound
  Worst negative;   ///< how far a multiplier lies outside of its set's normal cone, as it never may
};

/// (v, t) minus the nearest point of the second-order cone ‖v‖ ≤ t.
Eigen::VectorXd beyond_cone(const Eigen::VectorXd& s);

/// Of a control bound, Worst::entry is the control's; of a constraint, constraint_of gives its
/// place among those of the problem. `values` are g of all constraint rows.
Feasibility measure_feasibility(const ShootingProblem& problem, const SolutionClaims& claims,
                                const Eigen::VectorXd& values);
/// −1 where it is not a constraint's.
int constraint_of(const Worst& worst);

}  // namespace conddp
