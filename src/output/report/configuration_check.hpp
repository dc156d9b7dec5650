#pragma once

#include "analysis/certificate/check.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// Checks that the problem written in an answer, with all defaults, equals the built problem except
/// for the initial guess. The message names the first difference.
Check configuration_check(const OrderedJson& claimed, const ProblemSpec& spec,
                          const BuiltProblem& built);

}  // namespace conddp
