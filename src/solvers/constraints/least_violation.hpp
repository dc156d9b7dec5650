#pragma once

#include <memory>

#include "solvers/constraints/outer_strategy.hpp"

namespace conddp {

/// The strategy of a restoration. It minimizes cost + ½ρ Σ‖d‖², where d are the distances of hard
/// constraints from their sets, and ρ grows until the outcome is clear. The strategy ends as
/// `converged` if the violation is small, and as `infeasible` at a point of least violation
/// (ViolationSlope).
std::unique_ptr<OuterStrategy> least_violation_strategy(const ShootingProblem& problem,
                                                        const ControlBounds& bounds,
                                                        const SolverOptions& options);

}  // namespace conddp
