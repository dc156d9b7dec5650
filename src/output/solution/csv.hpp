#pragma once

#include <string>

#include "output/solution/solution.hpp"

namespace conddp {

/// trajectory.csv: t, phase, states, controls, contact forces (contact/<name>/fx ... in world
/// axes); one row a node, units in square brackets behind the names. Cells of what a node has not
/// are empty: controls and forces of the last node and of impulses, forces of contacts that are not
/// held. Where the first state is chosen it is the first row.
std::string trajectory_csv(const Solution& solution);

/// iterations.csv: the log, one row an iteration. Cells of what is not finite are empty.
std::string iterations_csv(const Solution& solution);

}  // namespace conddp
