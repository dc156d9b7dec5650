#pragma once

#include <string>

#include "analysis/margins/margins.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The output of `conddp margins --json` (schemas/margins.schema.json).
OrderedJson margins_json(const std::vector<MarginCurve>& curves, const StateNoise& noise,
                         const ProblemSpec& spec, const BuiltProblem& built,
                         const Trajectory& trajectory);

/// The margins as text: one line per bound, the closest first.
std::string margins_text(const OrderedJson& margins);

}  // namespace conddp
