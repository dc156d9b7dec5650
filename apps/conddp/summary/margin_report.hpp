#pragma once

#include <string>

#include "analysis/margins/margins.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The document that `conddp margins --json` prints (schemas/margins.schema.json).
OrderedJson margins_json(const std::vector<MarginCurve>& curves, const StateNoise& noise,
                         const ProblemSpec& spec, const BuiltProblem& built,
                         const Trajectory& trajectory);

/// The same for people: a line for each bound, the one that is closest first.
std::string margins_text(const OrderedJson& margins);

}  // namespace conddp
