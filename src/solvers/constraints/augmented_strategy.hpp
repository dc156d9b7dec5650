#pragma once

#include <memory>

#include "solvers/constraints/augmented_lagrangian.hpp"
#include "solvers/constraints/outer_strategy.hpp"

namespace conddp {

/// The augmented Lagrangian's strategy, whatever its schedule of multipliers.
std::unique_ptr<OuterStrategy> augmented_lagrangian_strategy(const ShootingProblem& problem,
                                                             const SolverOptions& options,
                                                             MultiplierSchedule schedule);

}  // namespace conddp
