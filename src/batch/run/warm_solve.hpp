#pragma once

#include <memory>
#include <string_view>

#include "analysis/certificate/certificate_doubt.hpp"
#include "batch/plan/problem_family.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// The starting point for a problem of the same shape: the answer that an item passes on to others.
struct NeighbourAnswer {
  Trajectory trajectory;
  std::shared_ptr<const DualGuess> multipliers;  ///< null: unknown
  const SolverInfo* solver = nullptr;            ///< solver of the answer; null: unknown
  /// Iterations of a cold start: of this item, or of the first one in its chain of starts.
  int cold_iterations = 0;
};

/// The starting point that led to an answer.
enum class StartKind {
  kOwn,      ///< the problem's own guess
  kWarm,     ///< a neighbor's answer, or a file
  kDropped,  ///< own guess, after dropping a misleading warm start
};
std::string_view to_string(StartKind kind);

/// An answer and its cost.
struct StartedSolve {
  SolveResult result;
  StartKind start = StartKind::kOwn;
  int dropped_iterations = 0;  ///< of a dropped start; not included in the result
  std::shared_ptr<const LastJudged> judged = nullptr;  ///< certificate from the solve, or null
};

/// The multipliers of an answer, as a guess for a problem of its shape.
std::shared_ptr<const DualGuess> multipliers_of(const SolveResult& result);

/// The answer of a solve for its neighbors. `from` is the answer that it started from, or null.
NeighbourAnswer answer_for_neighbours(const StartedSolve& solved, const SolverInfo* solver,
                                      const NeighbourAnswer* from);

/// Solves from the states, controls and multipliers of a problem of the same shape. A start that
/// has not converged after twice the iterations of a cold one is dropped. The problem is then
/// solved from its own guess in the remaining time. If `from` is null, it is solved from its own
/// guess directly.
StartedSolve solve_from(const NeighbourAnswer* from, const BuiltProblem& built,
                        const std::vector<const SolverInfo*>& candidates,
                        const SolverOptions& options, const SolverInfo*& solver);

}  // namespace conddp
