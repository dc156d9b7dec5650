#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "solvers/strategies/registry.hpp"

namespace conddp {

class DdpSolver;
class InteriorSolver;

/// A solver that keeps its memory between solves of one problem from changing initial states
/// (ShootingProblem::set_initial_state) and guesses, as in model predictive control. From the
/// second solve on, a solver of the DDP family allocates only for messages of failed solves.
/// `ipopt` starts anew each time, and so do solves of `ipddp` to the tolerances.
class ReusableSolver {
 public:
  /// The problem must outlive this object. Throws std::invalid_argument if no solver has this name,
  /// the solver does not support the problem or the options, or the options request restarts or a
  /// homotopy. `memory` is shared by solvers of problems with common models, only one of them
  /// solving at a time; null for a memory of its own.
  ReusableSolver(const ShootingProblem& problem, std::string_view solver,
                 const SolverOptions& options, std::shared_ptr<EvaluationMemory> memory = nullptr);
  ~ReusableSolver();
  ReusableSolver(const ReusableSolver&) = delete;
  ReusableSolver& operator=(const ReusableSolver&) = delete;

  /// Answers as solve() does, but without restorations of feasibility: `infeasible` is only a
  /// suspicion here. The answer is valid until the next call. Throws std::invalid_argument for a
  /// guess of another shape.
  const SolveResult& solve(const Trajectory& guess);
  /// A real-time iteration: the same, but sweeps are limited, and if the iterations are used up,
  /// the last iterate is not linearized. The gains are then those of the sweep that led to it,
  /// stationarity is that of the previous iterate, and multipliers follow from the values of the
  /// constraints. Co-states, gradients and constraint values stay zero. Throws
  /// std::logic_error for `ipopt`, which does not support it.
  const SolveResult& iterate(const Trajectory& guess);
  /// Moves the gains of the last answer out; `to` has their shape.
  void take_feedback(Feedback& to);
  /// Exchanges memory between solves with another solver of the same name, as far as their problems
  /// have the same shape; answers lose their gains. The memory of the last solver is in cache.
  void exchange_memory(ReusableSolver& other);

 private:
  std::unique_ptr<DdpSolver> solver_;      ///< null for a solver that starts anew
  std::unique_ptr<InteriorSolver> ticks_;  ///< of `ipddp`, for real-time iterations
  std::function<SolveResult(const Trajectory&)> anew_;
  std::optional<SolveResult> answer_;  ///< answer of such a solver
};

}  // namespace conddp
