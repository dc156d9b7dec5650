#include "solvers/common/settled_cost.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/common/tuning.hpp"

namespace conddp {

bool cost_has_settled(const std::vector<IterationRecord>& log, double share) {
  if (!(share > 0) || std::ssize(log) <= tuning::kSettledSteps) return false;
  return std::adjacent_find(
             log.end() - tuning::kSettledSteps - 1, log.end(),
             [&](const IterationRecord& before, const IterationRecord& row) {
               return !(std::abs(row.cost - before.cost) <= share * row.step * std::abs(row.cost));
             }) == log.end();
}

}  // namespace conddp
