#include "solvers/ipopt_solver.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

SolveResult run(const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) {
  return IpoptSolver(problem, options).solve(guess);
}

}  // namespace

/// Direct transcription by multiple shooting for the interior-point method Ipopt (Wächter, Biegler
/// 2006). MUMPS, which factors its matrices, must not run twice in one process.
SolverInfo ipopt() {
  return {.name = "ipopt",
          .description = "direct transcription to a sparse nonlinear program; all constraints",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .complementarity = true,
          .open_gaps = true,
          .exact_hessian = true,
          .concurrent = false,
          .run = run};
}

}  // namespace conddp
