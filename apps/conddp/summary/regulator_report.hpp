#pragma once

#include <string>

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// The regulator, the terminal set and the conditions of `terminal: {lqr: ...}`, which the problem
/// must contain, with the names of states and controls.
OrderedJson regulator_json(const BuiltProblem& built, double constraint_tolerance);

/// The regulator as text.
std::string regulator_text(const OrderedJson& terminal);

}  // namespace conddp
