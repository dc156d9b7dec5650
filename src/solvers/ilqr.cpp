#include "solvers/ddp_solver.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

SolveResult run(const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) {
  return DdpSolver(problem, {}, options).solve(guess);
}

}  // namespace

/// Iterative LQR (Li, Todorov 2004) with Tassa's regularisation: closed gaps, no bounds.
SolverInfo ilqr() {
  return {.name = "ilqr", .description = "single shooting, Gauss-Newton", .run = run};
}

}  // namespace conddp
