#include "solvers/common/status.hpp"

namespace conddp {

std::string_view to_string(SolveStatus status) {
  switch (status) {
    case SolveStatus::converged:
      return "converged";
    case SolveStatus::max_iterations:
      return "max_iterations";
    case SolveStatus::line_search_failed:
      return "line_search_failed";
    case SolveStatus::regularization_limit:
      return "regularization_limit";
    case SolveStatus::diverged:
      return "diverged";
    case SolveStatus::infeasible:
      return "infeasible";
    case SolveStatus::time_limit:
      return "time_limit";
    case SolveStatus::interrupted:
      return "interrupted";
    case SolveStatus::cost_settled:
      return "cost_settled";
  }
  return "unknown";
}

bool is_success(SolveStatus status) {
  return status == SolveStatus::converged || status == SolveStatus::cost_settled;
}

}  // namespace conddp
