#include "solvers/ddp_solver.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

SolveResult run(const ShootingProblem& problem, const SolverOptions& options,
                const Trajectory& guess) {
  return DdpSolver(problem,
                   {.open_gaps = true,
                    .constraints = true,
                    .multipliers = MultiplierSchedule::by_the_sweep,
                    .hessian = hessian_use(options)},
                   options)
      .solve(guess);
}

}  // namespace

/// Equality constraints in the null space of every stage's rows, multiple shooting (after Mastalli
/// et al. 2022, with terminal rows in the sweep).
SolverInfo intro() {
  return {.name = "intro",
          .description = "multiple shooting, equality constraints by null space",
          .constraints = ConstraintSupport::equalities,
          .open_gaps = true,
          .exact_hessian = true,
          .run = run};
}

}  // namespace conddp
