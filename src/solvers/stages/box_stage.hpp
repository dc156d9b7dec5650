#pragma once

#include <memory>

#include "solvers/stages/stage_solver.hpp"

namespace conddp {

/// k minimises the stage at δx = 0 subject to lower ≤ u + k ≤ upper; K has zero rows for clamped
/// controls (Tassa, Mansard, Todorov 2014, eqs. 9-11). Each knot starts from the active set that it
/// had in the sweep before.
///
/// That set is blind to what the knots before it do: `ActiveSet::revise` and held sweeps alternate
/// towards that of the whole horizon's box-constrained QP.
/// `segments`: of how many segments stages may be solved at once.
std::unique_ptr<StageSolver> box_stage(const ShootingProblem& problem,
                                       const SolverOptions::BoxQp& options, int segments = 1);

}  // namespace conddp
