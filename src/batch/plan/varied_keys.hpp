#pragma once

#include "batch/plan/batch_plan.hpp"
#include "batch/plan/problem_family.hpp"

namespace conddp {

/// Reports keys of the axes that are set twice in a problem, fully or in part. The other setting
/// may be another axis, another key of the plan, or the homotopy of the problem, which determines
/// its numbers. Keys are compared by meaning (`phases.0.dt` is `phases.reach.dt` if the first phase
/// has that name).
void check_varied_keys(const BatchPlan& plan, const ProblemFamily& family, Diagnostics& out);

}  // namespace conddp
