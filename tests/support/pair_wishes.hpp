#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "support/small_problems.hpp"

namespace conddp::testing {

/// ½ ‖u_k − wish_k‖² over knots x⁺ = x + u_k with pairs 0 ≤ u₁ ⊥ u₂ ≥ 0.
inline ShootingProblem wishes_for_pairs(const std::vector<Eigen::Vector2d>& wishes) {
  const auto system = linear_system(Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity(),
                                    Eigen::Vector2d::Zero());
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->add_cost("effort", control_residual(2, 2), {});
  running->add_constraint(
      make_constraint("pair", control_residual(2, 2), ConstraintKind::complementarity));
  Phase phase{.name = "go", .model = running};
  for (const Eigen::Vector2d& wish : wishes) {
    phase.dt.push_back(1);
    phase.cost_scale.push_back(1);
    for (const double number : {wish[0], wish[1], 1.0, 0.0, 0.0, 1.0})
      phase.parameters.push_back(number);
  }
  std::vector<Phase> phases;
  phases.push_back(std::move(phase));
  return ShootingProblem({0, 0}, std::move(phases),
                         {.name = "end",
                          .model = std::make_shared<KnotModel>(system, Integrator::none),
                          .dt = {0},
                          .cost_scale = {1}});
}

}  // namespace conddp::testing
