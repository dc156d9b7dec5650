#pragma once

#include <string>
#include <vector>

#include "ocp/problem/problem.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// What the problem file says of a constraint of the problem; null where it is not from there.
const ConstraintSpec* constraint_spec(const ProblemSpec& spec, const ShootingProblem& problem,
                                      const NodeConstraint& constraint);

/// The names of the rows of a constraint's residual: coordinates of the state, axes of a position,
/// pairs of shapes, ...; their numbers from 1 on where they have none.
std::vector<std::string> residual_row_names(const ProblemSpec& spec, const BuiltProblem& built,
                                            const ConstraintSpec& constraint,
                                            const Residual& residual);

}  // namespace conddp
