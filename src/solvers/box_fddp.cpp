#include "solvers/ddp_solver.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

SolveResult run(const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) {
  return DdpSolver(problem,
                   {.open_gaps = true,
                    .clamp_controls = true,
                    .box_stage = true,
                    .hessian = hessian_use(options)},
                   options)
      .solve(guess);
}

}  // namespace

/// Box-FDDP (Mastalli et al. 2022), but with stage problems that respect the bounds from the first
/// iteration on, closed gaps or not.
SolverInfo box_fddp() {
  return {.name = "box_fddp",
          .description = "multiple shooting, Gauss-Newton, control bounds by projected Newton",
          .control_bounds = BoundSupport::exact,
          .open_gaps = true,
          .exact_hessian = true,
          .run = run};
}

}  // namespace conddp
