#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// A constraint in the form of expand_problem, as a cost with this weight that is zero if the
/// constraint holds; null if no cost can express it.
OrderedJson softened(const OrderedJson& constraint, double weight);

/// Turns all constraints of an expanded problem except its control bounds into costs. A note names
/// each constraint that is omitted because no cost can express it.
void soften_constraints(OrderedJson& problem, std::vector<std::string>& notes);

}  // namespace conddp
