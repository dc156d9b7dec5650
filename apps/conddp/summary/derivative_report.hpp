#pragma once

#include <string>
#include <vector>

#include "analysis/derivatives/derivative_check.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The comparisons with names of phases, costs, rows and columns; `holds` is true if all are within
/// the tolerance.
OrderedJson derivatives_json(const std::vector<DerivativeComparison>& comparisons,
                             const ProblemSpec& spec, const BuiltProblem& built);

/// The comparisons as a text table.
std::string derivatives_text(const OrderedJson& derivatives);

}  // namespace conddp
