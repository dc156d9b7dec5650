#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "analysis/findings/finding.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Names of the rows of a constraint's residual: coordinates of the state, axes of a position,
/// pairs of shapes, ...; numbers from 1 on for rows without names. Empty if the constraint is not
/// one of the file. `problem` is the built one, or a dropped constraint alone.
std::vector<std::string> constraint_row_names(const BuiltProblem& built,
                                              const ShootingProblem& problem,
                                              const NodeConstraint& constraint);

/// The rows of a constraint's residual that are positions along x, y, z of the world, −1 for axes
/// without a row.
std::array<int, 3> rows_by_axis(const BuiltProblem& built, const NodeConstraint& constraint);

/// Names of the rows of a cost in a phase, or at the last node, whose index is the number of
/// phases.
std::vector<std::string> cost_row_names(const BuiltProblem& built, const CostTerm& term,
                                        std::size_t phase);

/// Names for findings about a motion of the problem, and what its file requests already.
FindingNames finding_names(const BuiltProblem& built);

/// The frames in costs and constraints of a robot, except those of contacts, by name.
std::map<std::string, int> watched_frames(const BuiltProblem& built);

/// Place of the number of knots of the phase that has most of them.
Place place_of_most_knots(const BuiltProblem& built);

/// Names of the parameters that the solver chooses. Each is a constant state and a control of the
/// first knot.
std::vector<std::string> free_parameter_names(const BuiltProblem& built);

/// True if the problem runs compiled code that the file names.
bool runs_code(const BuiltProblem& built);

}  // namespace conddp
