#pragma once

#include <vector>

#include "solvers/common/iteration_record.hpp"

namespace conddp {

/// Whether each of the last three steps changed the cost by at most `share` of it, had it gone on
/// at the same rate to its full length: a short step is no sign of a cost that has settled. False
/// where `share` is 0.
bool cost_has_settled(const std::vector<IterationRecord>& log, double share);

}  // namespace conddp
