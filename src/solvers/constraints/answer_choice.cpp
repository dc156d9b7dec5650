#include "solvers/constraints/answer_choice.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace conddp {

bool AnswerChoice::take(const KktNorms& norms, bool preferred) {
  const double left = excess(norms, tolerances_);
  if (taken_ && !(left < excess_) && !(preferred && left <= 1)) return false;
  taken_ = true;
  excess_ = left;
  return true;
}

double AnswerChoice::excess(const KktNorms& norms, const SolverOptions::Tolerances& tolerances) {
  double worst = 0;
  for (const auto& [norm, tolerance] :
       {std::pair(norms.stationarity.value, tolerances.stationarity),
        std::pair(norms.gap.value, tolerances.gap),
        std::pair(norms.violation.value, tolerances.constraint),
        std::pair(norms.complementarity, tolerances.complementarity)}) {
    if (!std::isfinite(norm)) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, norm / tolerance);
  }
  return worst;
}

}  // namespace conddp
