#include "solvers/ddp_solver.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

SolveResult run(const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) {
  return DdpSolver(problem, {.clamp_controls = true}, options).solve(guess);
}

}  // namespace

/// What everybody starts with: the sweep knows nothing of the bounds and the rollout cuts controls
/// off. Its convergence test is everyone's, so that it often ends short of converged.
SolverInfo ilqr_clip() {
  return {
      .name = "ilqr_clip",
      .description = "single shooting, Gauss-Newton, controls cut off at their bounds (a baseline)",
      .control_bounds = BoundSupport::clipped,
      .run = run};
}

}  // namespace conddp
