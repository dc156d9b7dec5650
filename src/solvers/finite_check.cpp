#include "solvers/finite_check.hpp"

#include <cmath>

namespace conddp {

std::optional<NonFinite> find_non_finite(const Linearization& linearization) {
  const int N = static_cast<int>(linearization.gap.cols());
  for (int k = 0; k <= N; ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    if (!std::isfinite(linearization.cost[k])) return NonFinite{k, "cost"};
    if (!std::isfinite(linearization.augmentation[k])) return NonFinite{k, "constraint"};
    if (k < N && !linearization.gap.col(k).allFinite()) return NonFinite{k, "next state"};
    if (!knot.gradient.allFinite()) return NonFinite{k, "cost gradient"};
    if (!knot.F.allFinite()) return NonFinite{k, "dynamics Jacobian"};
    if (!knot.hessian.allFinite()) return NonFinite{k, "Hessian"};
  }
  return std::nullopt;
}

}  // namespace conddp
