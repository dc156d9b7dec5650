#pragma once

#include <map>
#include <optional>
#include <vector>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Units, powers of two, that make the numbers of a problem about 1: x and u are multiples of them.
struct ProblemUnits {
  struct OfModel {
    std::vector<double> control;      ///< nu
    std::vector<double> row_factors;  ///< factors of the constraint rows
  };
  std::vector<double> state;  ///< nx
  std::map<const KnotModel*, OfModel> models;
  double cost = 1;         ///< factor of the costs
  bool far_apart = false;  ///< some state, control or row is beyond 2¹³

  const OfModel& at(const ShootingProblem& problem, int k) const {
    return models.at(problem.knot(k).model);
  }
};

/// Units of a problem with constraints. Empty if states and controls are between 2⁻⁵ and 2⁵ and
/// derivatives of rows above 2⁻⁵, or if derivatives at the guess are not finite. Also empty if
/// rotations, semi-implicit dynamics or complementary pairs tie the states to their units.
///
/// The size of a state or control follows from the guess, from equalities that depend on it alone,
/// and from its bounds. Bounds of a state are used only if nothing else is known about it. A size
/// that is still unknown is 1 if numbers lie far apart; otherwise it follows from responses to
/// controls. Rows of hard constraints are scaled so that their largest derivative at the guess, in
/// the units of their variables, is 1. Costs are scaled to change by 1 if all variables move by
/// their units.
std::optional<ProblemUnits> units_of(const ShootingProblem& problem, const Trajectory& guess);

/// The problem with states, controls and rows in these units, and with its own models. Costs are
/// unchanged.
ShootingProblem in_units(const ShootingProblem& problem, const ProblemUnits& units);

}  // namespace conddp
