#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build_mpc.hpp"

namespace conddp {

/// Summary of a problem as conddp understands it (schemas/check.schema.json, without the
/// derivatives), with the solvers to be tried, at least one. `loop` belongs to its section `mpc`,
/// null without such a section.
OrderedJson check_summary(const ProblemSpec& spec, const BuiltProblem& built,
                          const std::vector<const SolverInfo*>& candidates, const BuiltMpc* loop);

/// The summary as text.
std::string check_text(const OrderedJson& summary);

}  // namespace conddp
