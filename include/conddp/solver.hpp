// Solvers, their options and results.
//
//   SolverOptions options{.max_iterations = 200};
//   options.on_iteration = [](const IterationRecord& row) { ... };
//   const SolveResult result = solve(problem, "box_fddp", options, problem.create_trajectory());
//   if (result.status == SolveStatus::converged) use(result.trajectory, result.feedback);
//
// solvers() lists the solvers with what they support; the name "auto" takes one that suits the
// problem, and others if it does not converge. A solve converges when stationarity, dynamics gap,
// constraint violation and complementarity are all under SolverOptions::tolerances. Every other end
// is a status, with the last iterate and a sentence about the cause; only what cannot be solved at
// all (options out of range, a solver that does not support the problem, a guess of another shape)
// throws std::invalid_argument.
//
// Answers do not depend on the number of threads, bit for bit. Each call of solve() has memory of
// its own and may run beside others; only "ipopt" must not run twice at once in a process
// (SolverInfo::concurrent).
//
// In a loop, as in model predictive control, a ReusableSolver keeps its memory. From the second
// solve on it allocates nothing, but for messages of solves that fail and by "ipopt":
//
//   ReusableSolver solver(problem, "box_fddp", options);
//   for (;;) {
//     problem.set_initial_state(measured);
//     const SolveResult& plan = solver.solve(guess);
//     apply(plan.trajectory.u(0));
//     guess = plan.trajectory;  // shifted by a knot
//   }
//
// The control between two solves is u_k + K_k (x ⊖ x_k), with the gains of `feedback`.
#pragma once

#include "solvers/common/iteration_record.hpp"
#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/common/status.hpp"
#include "solvers/common/strategy_record.hpp"
#include "solvers/strategies/registry.hpp"
#include "solvers/strategies/reusable_solver.hpp"
