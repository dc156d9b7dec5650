#pragma once

#include <functional>

#include "problem_file/model/spec.hpp"

namespace conddp {

/// Counts knots and nodes that are given by a phase from the first knot of all. Reports unknown
/// phases, knots that a list has twice, and way-points that do not increase.
void number_knots(ProblemSpec& spec, Diagnostics& out);

/// Reports knots and nodes that a problem counts and its phases lack.
void check_knots(const ProblemSpec& spec, Diagnostics& out);

/// Gives nodes of a problem new numbers wherever it counts knots: where costs and constraints hold,
/// way-points, keyframes, the path of a gait.
void renumber(ProblemSpec& spec, const std::function<int(int)>& number_of);

/// Gives the phases that take time new numbers of knots; their durations stay.
void set_knots(ProblemSpec& spec, const std::function<int(int)>& knots_of);

/// Cuts each step of the phases into `mesh.factor` steps. Exceeding the knots of the mesh is an
/// error. With collocation, lowers the constraint tolerance, which also applies to the equations of
/// the steps, so far that the error of the mesh is that of its steps.
void cut_steps(ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
