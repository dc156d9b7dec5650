#pragma once

#include "output/json_text.hpp"
#include "output/solution.hpp"

namespace conddp {

/// What was solved and how it ended, without the bulk: problem, tool, status, costs, residuals,
/// times, guess.
OrderedJson solution_head(const Solution& solution);

/// Which conddp it was: version, revision, build, libraries.
OrderedJson tool_json();

/// The whole of solution.json (schemas/solution.schema.json).
OrderedJson solution_json(const Solution& solution);

}  // namespace conddp
