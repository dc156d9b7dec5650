#include "solvers/common/finite_check.hpp"

#include <cmath>

namespace conddp {

std::optional<NonFinite> find_non_finite(const Linearization& linearization) {
  const int N = static_cast<int>(linearization.gap.cols());
  for (int k = 0; k <= N; ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    if (!std::isfinite(linearization.cost[k])) return NonFinite{k, "cost"};
    if (!std::isfinite(linearization.augmentation[k])) return NonFinite{k, "constraint"};
    if (k < N && !all_finite(linearization.gap.col(k))) return NonFinite{k, "next state"};
    if (!all_finite(knot.gradient)) return NonFinite{k, "cost gradient"};
    if (!all_finite(knot.F)) return NonFinite{k, "dynamics Jacobian"};
    if (!all_finite(knot.hessian())) return NonFinite{k, "Hessian"};
  }
  return std::nullopt;
}

}  // namespace conddp
