#include "solvers/ddp_solver.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

SolveResult run(const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) {
  return DdpSolver(problem, {.hessian = HessianUse::exact}, options).solve(guess);
}

}  // namespace

/// Differential dynamic programming (Mayne 1966): the Lagrangian's exact Hessian, with the
/// co-states of the iterate, converges quadratically; indefinite stages are regularised.
SolverInfo ddp() {
  return {.name = "ddp",
          .description = "single shooting, exact second derivatives",
          .gauss_newton_hessian = false,
          .exact_hessian = true,
          .run = run};
}

}  // namespace conddp
