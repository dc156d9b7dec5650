#pragma once

#include <string>
#include <vector>

#include "analysis/derivatives/derivative_check.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The comparisons with the names of phases, costs, rows and columns; `holds` says whether all are
/// within the tolerance.
OrderedJson derivatives_json(const std::vector<DerivativeComparison>& comparisons,
                             const ProblemSpec& spec, const BuiltProblem& built);

/// The same as a table for people.
std::string derivatives_text(const OrderedJson& derivatives);

}  // namespace conddp
