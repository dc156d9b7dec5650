#pragma once

#include <memory>

#include "solvers/constraints/augmented_lagrangian.hpp"
#include "solvers/constraints/outer_strategy.hpp"

namespace conddp {

/// The strategy of the augmented Lagrangian, for any schedule of multipliers.
std::unique_ptr<OuterStrategy> augmented_lagrangian_strategy(const ShootingProblem& problem,
                                                             const SolverOptions& options,
                                                             MultiplierSchedule schedule);

}  // namespace conddp
