#pragma once

#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/build_mpc.hpp"

namespace conddp {

/// Summary of a problem as conddp understands it (schemas/check.schema.json, without the
/// derivatives), with the solvers to be tried, at least one. `loop` belongs to its section `mpc`,
/// null without such a section.
OrderedJson problem_summary(const BuiltProblem& built,
                            const std::vector<const SolverInfo*>& candidates, const BuiltMpc* loop);

}  // namespace conddp
