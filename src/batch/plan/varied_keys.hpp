#pragma once

#include "batch/plan/batch_plan.hpp"
#include "batch/plan/problem_family.hpp"

namespace conddp {

/// Reports keys of the axes that are set twice in a problem, or in part, whatever they are called
/// there (`phases.0.dt` is `phases.reach.dt` if the first phase has that name): by another axis, by
/// another key of the plan, or by the homotopy of the problem, which decides on its numbers.
void check_varied_keys(const BatchPlan& plan, const ProblemFamily& family, Diagnostics& out);

}  // namespace conddp
