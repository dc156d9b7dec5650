#include "solvers/ipopt_solver.hpp"
#include "solvers/registry.hpp"
#include "solvers/restarts.hpp"

namespace conddp {
namespace {

SolveResult run(const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) {
  if (options.restarts.count == 0) return IpoptSolver(problem, options).solve(guess);
  SolverOptions silent = options;
  silent.on_iteration = nullptr;
  silent.threads = 1;
  const Trajectory start = best_start(problem, options, guess, [&](const Trajectory& t) {
    return IpoptSolver(problem, silent).solve(t);
  });
  return IpoptSolver(problem, options).solve(start);
}

}  // namespace

/// Direct transcription by multiple shooting for the interior-point method Ipopt (Wächter, Biegler
/// 2006).
SolverInfo ipopt() {
  return {.name = "ipopt",
          .description = "direct transcription to a sparse nonlinear program; all constraints",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .complementarity = true,
          .open_gaps = true,
          .exact_hessian = true,
          .run = run};
}

}  // namespace conddp
