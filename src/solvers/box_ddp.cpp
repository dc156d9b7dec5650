#include "solvers/ddp_solver.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

SolveResult run(const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) {
  return DdpSolver(problem,
                   {.clamp_controls = true, .box_stage = true, .hessian = hessian_use(options)},
                   options)
      .solve(guess);
}

}  // namespace

/// Control-limited DDP (Tassa, Mansard, Todorov 2014): Gauss-Newton unless the options ask for
/// exact second derivatives.
SolverInfo box_ddp() {
  return {.name = "box_ddp",
          .description = "single shooting, control bounds by projected Newton",
          .control_bounds = BoundSupport::exact,
          .exact_hessian = true,
          .run = run};
}

}  // namespace conddp
