#pragma once

#include <string>
#include <vector>

#include "ocp/problem/problem.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The constraint's entry in the problem file; null if it has another origin.
const ConstraintSpec* constraint_spec(const ProblemSpec& spec, const ShootingProblem& problem,
                                      const NodeConstraint& constraint);

/// Names of the rows of a constraint's residual: coordinates of the state, axes of a position,
/// pairs of shapes, ...; numbers from 1 on for rows without names.
std::vector<std::string> residual_row_names(const ProblemSpec& spec, const BuiltProblem& built,
                                            const ConstraintSpec& constraint,
                                            const Residual& residual);

}  // namespace conddp
