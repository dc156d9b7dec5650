#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "solvers/strategies/registry.hpp"

namespace conddp {

class DdpSolver;

/// A solver whose memory outlives a solve, for one problem that is solved again and again from
/// other initial states (ShootingProblem::set_initial_state) and guesses, as in model predictive
/// control. From the second solve on a solver of the DDP family allocates nothing, but for messages
/// of solves that fail; `ipopt` begins anew each time.
class ReusableSolver {
 public:
  /// The problem must outlive this object. Throws std::invalid_argument where no solver has this
  /// name, it does not support the problem or the options, or these ask for restarts or a homotopy.
  /// `memory` is shared by solvers of problems with common models of which one solves at a time;
  /// null: a memory of its own.
  ReusableSolver(const ShootingProblem& problem, std::string_view solver,
                 const SolverOptions& options, std::shared_ptr<EvaluationMemory> memory = nullptr);
  ~ReusableSolver();
  ReusableSolver(const ReusableSolver&) = delete;
  ReusableSolver& operator=(const ReusableSolver&) = delete;

  /// The answer is that of solve() up to restorations of feasibility, which this does not try:
  /// `infeasible` is a suspicion here. It stays until the next call. A guess of another shape is a
  /// std::invalid_argument.
  const SolveResult& solve(const Trajectory& guess);
  /// A real-time iteration: the same, but where the iterations are used up the last iterate is not
  /// linearised. The gains are then those of the sweep that led to it, the stationarity is that of
  /// the iterate before, and co-states, gradients and values of constraints stay zero. Of `ipopt`,
  /// which has none, it is a std::logic_error.
  const SolveResult& iterate(const Trajectory& guess);
  /// Moves the gains of the last answer out; `to` has their shape.
  void take_feedback(Feedback& to);
  /// Between solves: exchanges memory with another one of the same name, as far as their problems
  /// have the same shape; answers lose their gains. The one that solved last has its memory in
  /// caches.
  void exchange_memory(ReusableSolver& other);

 private:
  std::unique_ptr<DdpSolver> solver_;  ///< null of a solver that begins anew
  std::function<SolveResult(const Trajectory&)> anew_;
  std::optional<SolveResult> answer_;  ///< of such a solver
};

}  // namespace conddp
