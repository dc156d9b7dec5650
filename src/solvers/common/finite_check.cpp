#include "solvers/common/finite_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace conddp {
namespace {

/// First quantity of a node that is not finite; empty if all are finite.
std::string_view non_finite_quantity(const Linearization& linearization, int node) {
  const KnotLinearization& knot = linearization.knots[node];
  const bool has_next = node < linearization.gap.cols();
  const std::pair<std::string_view, bool> finite[] = {
      {"cost", std::isfinite(linearization.cost[node])},
      {"constraint", std::isfinite(linearization.augmentation[node])},
      {"next state", !has_next || all_finite(linearization.gap.col(node))},
      {"dynamics Jacobian", all_finite(knot.F)},  // before quantities that may be computed from it
      {"cost gradient", all_finite(knot.gradient)},
      {"Hessian", all_finite(knot.hessian())}};
  const auto* found =
      std::find_if(std::begin(finite), std::end(finite), [](const auto& q) { return !q.second; });
  return found == std::end(finite) ? "" : found->first;
}

}  // namespace

std::optional<NonFinite> find_non_finite(const Linearization& linearization) {
  const int nodes = static_cast<int>(linearization.knots.size());
  for (int k = 0; k < nodes; ++k) {
    const std::string_view quantity = non_finite_quantity(linearization, k);
    if (!quantity.empty()) return NonFinite{k, quantity};
  }
  return std::nullopt;
}

}  // namespace conddp
