#pragma once

#include <string>

#include "output/solution/solution.hpp"

namespace conddp {

/// trajectory.npz, for numpy.load: t (N + 1), x ((N + 1) x nx), u and k (N x nu), K (N x nu x ndx),
/// costates ((N + 1) x ndx), contact/<name> (N x 6: force in N and torque in Nm on the robot in
/// world axes), and the names and units of x and u. NaN where there is no value: controls that a
/// phase lacks, forces of open contacts.
std::string solution_npz(const Solution& solution);

}  // namespace conddp
