#pragma once

#include <map>
#include <optional>
#include <vector>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Units in which the numbers of a problem are about 1, powers of two: x and u are so many times
/// these.
struct ProblemUnits {
  struct OfModel {
    std::vector<double> control;      ///< nu
    std::vector<double> row_factors;  ///< what the rows of constraints are multiplied by
  };
  std::vector<double> state;  ///< nx
  std::map<const KnotModel*, OfModel> models;
  double cost = 1;         ///< what costs are multiplied by
  bool far_apart = false;  ///< some state, control or row is beyond 2¹³

  const OfModel& at(const ShootingProblem& problem, int k) const {
    return models.at(problem.knot(k).model);
  }
};

/// The units of a problem with constraints; none where states and controls are between 2⁻⁵ and 2⁵
/// and derivatives of rows above 2⁻⁵, where the derivatives at the guess are not finite, or where
/// rotations, semi-implicit dynamics or complementary pairs tie the states to their units.
///
/// A state or control is as large as in the guess, where an equality that depends on it alone has
/// its value, and as its bounds; those of a state count where nothing else is known of it. What is
/// not known then is 1 where numbers lie far apart, and else what responses to controls say. Rows
/// of hard constraints get the derivative 1 by the largest of their variables at the guess, and
/// costs the change 1 where all variables move by their units.
std::optional<ProblemUnits> units_of(const ShootingProblem& problem, const Trajectory& guess);

/// The problem with states, controls and rows in these units, and with models of its own. Costs are
/// what they were.
ShootingProblem in_units(const ShootingProblem& problem, const ProblemUnits& units);

}  // namespace conddp
