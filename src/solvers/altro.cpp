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
                    .constraints = true,
                    .newton = true,
                    .hessian = hessian_use(options)},
                   options)
      .solve(guess);
}

}  // namespace

/// ALTRO (Howell, Jackson, Manchester 2019; cones: Jackson et al. 2021): an augmented Lagrangian
/// around multiple shooting. Bounds on the control stay with the stage problems.
SolverInfo altro() {
  return {.name = "altro",
          .description = "augmented Lagrangian around multiple shooting; all constraints",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .open_gaps = true,
          .exact_hessian = true,
          .run = run};
}

}  // namespace conddp
