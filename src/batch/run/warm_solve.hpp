#pragma once

#include <memory>
#include <string_view>

#include "analysis/certificate/certificate.hpp"
#include "batch/plan/problem_family.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// From what a problem of the same shape starts: what an item leaves to those that start from it.
struct NeighbourAnswer {
  Trajectory trajectory;
  std::shared_ptr<const DualGuess> multipliers;  ///< null: unknown
  const SolverInfo* solver = nullptr;            ///< that found it; null: unknown
  /// Iterations of a cold start: of this item, or of the one that it goes back to.
  int cold_iterations = 0;
};

/// From which start an answer came.
enum class StartKind {
  kOwn,      ///< the problem's own guess
  kWarm,     ///< a neighbour's answer, or a file
  kDropped,  ///< its own guess, after a start from these that misled
};
std::string_view to_string(StartKind kind);

/// An answer and what it cost.
struct StartedSolve {
  SolveResult result;
  StartKind start = StartKind::kOwn;
  int dropped_iterations = 0;  ///< of a start that was dropped, besides those of the result
  /// Of the answers that the solve showed to the certificate; null: none.
  std::shared_ptr<const SecondOrderMemory> certified = nullptr;
};

/// The answer of a solve for its neighbours. `from`: the one that it started from, or null.
NeighbourAnswer answer_for_neighbours(const StartedSolve& solved, const SolverInfo* solver,
                                      const NeighbourAnswer* from);

/// Solves from states, controls and multipliers for a problem of the same shape. A start that has
/// not converged after twice the iterations that a cold one took misleads: it is dropped, and the
/// problem is solved from its own guess in the time that is left. `from` null: from its own guess
/// at once.
StartedSolve solve_from(const NeighbourAnswer* from, const ProblemInstance& instance,
                        const std::vector<const SolverInfo*>& candidates,
                        const SolverOptions& options, const SolverInfo*& solver);

}  // namespace conddp
