#pragma once

#include <memory>

#include "solvers/stages/stage_solver.hpp"

namespace conddp {

/// k minimizes the stage at δx = 0 subject to lower ≤ u + k ≤ upper; K has zero rows for clamped
/// controls (Tassa, Mansard, Todorov 2014, eqs. 9-11). Each knot starts from its active set in the
/// previous sweep.
///
/// This set ignores the steps of earlier knots. Alternating `ActiveSet::revise` and held sweeps
/// approach the active set of the horizon's box-constrained QP.
/// `segments`: number of segments whose stages may be solved at once.
std::unique_ptr<StageSolver> box_stage(const ShootingProblem& problem, int segments = 1);

}  // namespace conddp
