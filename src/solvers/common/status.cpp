#include "solvers/common/status.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace conddp {
namespace {

using enum SolveStatus;

constexpr std::pair<SolveStatus, std::string_view> kNames[] = {
    {converged, "converged"},
    {max_iterations, "max_iterations"},
    {line_search_failed, "line_search_failed"},
    {regularization_limit, "regularization_limit"},
    {diverged, "diverged"},
    {infeasible, "infeasible"},
    {time_limit, "time_limit"},
    {interrupted, "interrupted"},
    {cost_settled, "cost_settled"},
};

}  // namespace

std::string_view to_string(SolveStatus status) {
  const auto* found = std::find_if(std::begin(kNames), std::end(kNames),
                                   [&](const auto& entry) { return entry.first == status; });
  return found == std::end(kNames) ? "unknown" : found->second;
}

bool is_success(SolveStatus status) {
  return status == SolveStatus::converged || status == SolveStatus::cost_settled;
}

}  // namespace conddp
