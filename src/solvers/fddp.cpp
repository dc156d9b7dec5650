#include "solvers/ddp_solver.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

SolveResult run(const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) {
  return DdpSolver(problem, {.open_gaps = true, .hessian = hessian_use(options)}, options)
      .solve(guess);
}

}  // namespace

/// Feasibility-driven DDP (Mastalli et al. 2020) with an l1 merit: starts from any states and
/// contracts the gaps by the step length.
SolverInfo fddp() {
  return {.name = "fddp",
          .description = "multiple shooting, Gauss-Newton",
          .open_gaps = true,
          .exact_hessian = true,
          .run = run};
}

}  // namespace conddp
