#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build_mpc.hpp"

namespace conddp {

/// What conddp understood of a problem (schemas/check.schema.json, without the derivatives), and
/// the solvers that would be tried, one at least. `loop`: of its section `mpc`; null: it has none.
OrderedJson check_summary(const ProblemSpec& spec, const BuiltProblem& built,
                          const std::vector<const SolverInfo*>& candidates, const BuiltMpc* loop);

/// The same for people.
std::string check_text(const OrderedJson& summary);

}  // namespace conddp
