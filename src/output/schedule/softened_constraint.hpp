#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// A constraint, as expand_problem writes one, as a cost of this weight that is zero where it
/// holds; null where no cost says it.
OrderedJson softened(const OrderedJson& constraint, double weight);

/// All constraints of an expanded problem but the bounds on its controls, as costs. A note names
/// each that no cost says: it is left out.
void soften_constraints(OrderedJson& problem, std::vector<std::string>& notes);

}  // namespace conddp
