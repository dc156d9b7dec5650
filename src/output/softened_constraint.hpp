#pragma once

#include "problem_file/ordered_json.hpp"

namespace conddp {

/// A constraint, as expand_problem writes one, as a cost of this weight that is zero where it
/// holds; null where no cost says it.
OrderedJson softened(const OrderedJson& constraint, double weight);

}  // namespace conddp
