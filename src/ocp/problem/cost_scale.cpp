#include "ocp/problem/cost_scale.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace conddp {
namespace {

/// Binary logarithms of the mean weight that is aimed at, and of the least and largest mean that
/// stay as they are: the weights of the example problems and of the literature lie well within.
constexpr double kUsual = -5, kLeast = -17, kLargest = 7;

/// Of the largest weight, less is negligible.
constexpr double kNegligible = 1e-10;

/// Weights of which the least that is not negligible is asked for.
class Weights {
 public:
  void meet(double weight) {
    weight = std::abs(weight);
    if (weight > 0 && std::isfinite(weight)) list_.push_back(weight);
  }
  bool are_none() const { return list_.empty(); }
  /// The binary logarithm of the geometric mean of the largest and the least.
  double middle() const {
    const double largest = *std::ranges::max_element(list_);
    double least = largest;
    for (const double weight : list_)
      if (weight >= kNegligible * largest) least = std::min(least, weight);
    return 0.5 * (std::log2(least) + std::log2(largest));
  }

 private:
  std::vector<double> list_;
};

void meet_weights(const KnotView& knot, Weights& weights) {
  for (const CostTerm& term : knot.model->costs()) {
    const double weight = knot.cost_scale * knot.parameters[term.weight];
    if (term.activation.weights.empty()) weights.meet(weight);
    for (const double own : term.activation.weights) weights.meet(weight * own);
  }
  for (const ConstraintTerm& term : knot.model->constraints())
    if (term.softness != Softness::hard && knot.parameters[term.active()] != 0)
      weights.meet(knot.cost_scale * knot.parameters[term.weight()]);
}

void scale_knots(Phase& phase, double scale) {
  for (double& own : phase.cost_scale) own *= scale;
}

}  // namespace

double cost_scale(const ShootingProblem& problem) {
  Weights weights;
  for (int k = 0; k <= problem.knots(); ++k) meet_weights(problem.knot(k), weights);
  if (weights.are_none()) return 1;
  const double middle = weights.middle();
  if (middle >= kLeast && middle <= kLargest) return 1;
  return std::exp2(std::round(kUsual - middle));
}

ShootingProblem scale_costs(const ShootingProblem& problem, double scale) {
  std::vector<Phase> phases = problem.phases();
  Phase terminal = problem.terminal();
  for (Phase& phase : phases) scale_knots(phase, scale);
  scale_knots(terminal, scale);
  return ShootingProblem(problem.initial_state(), std::move(phases), std::move(terminal));
}

}  // namespace conddp
