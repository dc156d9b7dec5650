#pragma once

#include <string>

#include "base/json/ordered_json.hpp"
#include "output/solution/contact_forces.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// Headers of the columns of contact forces (contact/<name>/fx ...), a comma before each.
std::string contact_headers(const ContactForces& forces);

/// Appends the cells of a row of contact forces, a comma before each: empty ones for contacts that
/// are not held, and for all where none are to be written.
void append_contact_cells(const ContactForces& forces, int row, bool written, std::string& text);

/// trajectory.csv: t, phase, states, controls, contact forces (contact/<name>/fx ... in world
/// axes); one row a node, units in square brackets behind the names. Cells of what a node has not
/// are empty: controls and forces of the last node and of impulses, forces of contacts that are not
/// held. Where the first state is chosen it is the first row.
std::string trajectory_csv(const BuiltProblem& built, const Trajectory& trajectory,
                           const ContactForces& forces);

/// iterations.csv from the log of a solution.json: one row an iteration. Cells of what is not
/// finite are empty.
std::string iterations_csv(const OrderedJson& log);

}  // namespace conddp
