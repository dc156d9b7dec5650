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
                    .multipliers = MultiplierSchedule::bound_constrained_lagrangian,
                    .legs = true,
                    .hessian = hessian_use(options)},
                   options)
      .solve(guess);
}

}  // namespace

/// ProxDDP (Jallet, Bambade, Kazdadi, Carpentier, Mansard 2025): a proximal primal-dual augmented
/// Lagrangian around multiple shooting. Bounds on the control stay with the stage problems.
SolverInfo proxddp() {
  return {.name = "proxddp",
          .description = "proximal augmented Lagrangian around multiple shooting; all constraints",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .open_gaps = true,
          .exact_hessian = true,
          .legs = true,
          .run = run};
}

}  // namespace conddp
