#pragma once

#include <string>
#include <vector>

#include "ocp/problem.hpp"

namespace conddp {

/// How many of the rows of a knot's contacts are independent, by the eigenvalues of G = J M⁻¹ Jᵀ
/// against the compliance that ContactSet gives a singular one. Rows along which the contact cannot
/// move at all, as out of the plane of a planar robot, do not count.
struct ContactRank {
  int rows = 0;  ///< 0: no contact is held
  int rank = 0;
  std::vector<std::string> contacts;

  bool redundant() const { return rank < rows; }
};

/// Of the contacts held at knot k of a trajectory.
ContactRank contact_rank(const ShootingProblem& problem, const Trajectory& trajectory, int k);

}  // namespace conddp
