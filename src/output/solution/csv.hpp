#pragma once

#include <string>

#include "base/json/ordered_json.hpp"
#include "output/solution/contact_forces.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Headers of the columns of contact forces (contact/<name>/fx ...), each preceded by a comma.
std::string contact_headers(const ContactForces& forces);

/// Appends the cells of a row of contact forces, each preceded by a comma. Cells of open contacts
/// are empty, and all cells unless `written`.
void append_contact_cells(const ContactForces& forces, int row, bool written, std::string& text);

/// trajectory.csv: t, phase, states, controls, contact forces (contact/<name>/fx ... in world
/// axes); one row per node, units in square brackets after the names. Cells without a value are
/// empty: controls and forces of the last node and of impulses, and forces of open contacts. A free
/// initial state is the first row.
std::string trajectory_csv(const BuiltProblem& built, const Trajectory& trajectory,
                           const ContactForces& forces);

/// iterations.csv from the log of a solution.json: one row per iteration. Non-finite cells are
/// empty.
std::string iterations_csv(const OrderedJson& log);

}  // namespace conddp
