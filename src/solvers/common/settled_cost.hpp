#pragma once

#include <vector>

#include "solvers/common/iteration_record.hpp"

namespace conddp {

/// True if each of the last three steps changed the cost by at most `share` of it, scaled to a full
/// step. A short step does not show that the cost has settled. False if `share` is 0.
bool cost_has_settled(const std::vector<IterationRecord>& log, double share);

}  // namespace conddp
