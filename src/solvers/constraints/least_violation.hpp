#pragma once

#include <memory>

#include "solvers/constraints/outer_strategy.hpp"

namespace conddp {

/// The strategy of a restoration: minimises cost + ½ρ Σ‖d‖², with d the distances of hard
/// constraints from their sets, for a ρ that grows as long as nothing is decided. It ends as
/// `converged` where the violation is small, and as `infeasible` at a point of least violation
/// (ViolationSlope).
std::unique_ptr<OuterStrategy> least_violation_strategy(const ShootingProblem& problem,
                                                        const ControlBounds& bounds,
                                                        const SolverOptions& options);

}  // namespace conddp
