#pragma once

#include <string>

#include "output/solution.hpp"

namespace conddp {

/// trajectory.csv: t, phase, states, controls; one row a node, units in square brackets behind the
/// names. The last node has no controls: its cells are empty.
std::string trajectory_csv(const Solution& solution);

/// iterations.csv: the log, one row an iteration. Cells of what is not finite are empty.
std::string iterations_csv(const Solution& solution);

}  // namespace conddp
