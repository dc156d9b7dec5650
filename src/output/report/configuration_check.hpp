#pragma once

#include "analysis/certificate/check.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// Whether the problem that an answer writes down with every default is the one that was built, but
/// for the first guess. The message names the first difference.
Check configuration_check(const OrderedJson& claimed, const ProblemSpec& spec,
                          const BuiltProblem& built);

}  // namespace conddp
