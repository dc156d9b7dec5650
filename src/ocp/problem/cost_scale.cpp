#include "ocp/problem/cost_scale.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace conddp {
namespace {

/// Binary logarithms of the target for the mean weight, and of the smallest and largest mean that
/// are left unscaled. Weights of the example problems and of the literature lie well within.
constexpr double kUsual = -5, kLeast = -17, kLargest = 7;

/// Weights below this share of the largest weight are negligible.
constexpr double kNegligible = 1e-10;

/// Calls f with the magnitude of each nonzero weight of a knot.
template <class F>
void for_each_weight(const KnotView& knot, const F& f) {
  const auto meet = [&f](double weight) {
    weight = std::abs(weight);
    if (weight > 0 && std::isfinite(weight)) f(weight);
  };
  for (const CostTerm& term : knot.model->costs()) {
    const double weight = knot.cost_scale * knot.parameters[term.weight];
    if (term.activation.weights.empty()) meet(weight);
    for (const double own : term.activation.weights) meet(weight * own);
  }
  for (const ConstraintTerm& term : knot.model->constraints())
    if (term.softness != Softness::hard && knot.parameters[term.active()] != 0)
      meet(knot.cost_scale * knot.parameters[term.weight()]);
}

/// The largest weight, and the smallest weight ≥ `share` of it; 0 and infinity without weights.
std::pair<double, double> weights_of(const ShootingProblem& problem, double share) {
  double largest = 0, least = std::numeric_limits<double>::infinity();
  const auto for_all = [&](const auto& f) {
    for (int k = 0; k <= problem.knots(); ++k) for_each_weight(problem.knot(k), f);
  };
  for_all([&](double weight) { largest = std::max(largest, weight); });
  for_all([&](double weight) {
    if (weight >= share * largest) least = std::min(least, weight);
  });
  return {largest, least};
}

void scale_knots(Phase& phase, double scale) {
  for (double& own : phase.cost_scale) own *= scale;
}

}  // namespace

double cost_scale(const ShootingProblem& problem) {
  const auto [largest, least] = weights_of(problem, kNegligible);
  if (largest == 0) return 1;
  const double middle = 0.5 * (std::log2(least) + std::log2(largest));
  if (middle >= kLeast && middle <= kLargest) return 1;
  return std::exp2(std::round(kUsual - middle));
}

double least_cost(const ShootingProblem& problem) {
  constexpr double kMove = 1e-6, kRounding = 1e-12;
  const auto [largest, least] = weights_of(problem, 0);
  if (largest == 0) return std::numeric_limits<double>::infinity();
  return std::max(kMove * kMove * std::min(1.0, least), kRounding * kRounding * largest);
}

ShootingProblem scale_costs(const ShootingProblem& problem, double scale) {
  std::vector<Phase> phases = problem.phases();
  Phase terminal = problem.terminal();
  for (Phase& phase : phases) scale_knots(phase, scale);
  scale_knots(terminal, scale);
  return ShootingProblem(problem.initial_state(), std::move(phases), std::move(terminal));
}

}  // namespace conddp
