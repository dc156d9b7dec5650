#include "batch/run/warm_solve.hpp"

#include <algorithm>
#include <limits>

namespace conddp {
namespace {

/// Limits a warm start to kTrialFactor times the iterations of a cold one, but at least
/// kLeastTrial. Many converging warm starts take slightly more iterations than the cold start of
/// another item.
constexpr int kTrialFactor = 2, kLeastTrial = 10;
constexpr double kLeastTime = 1e-3;  // s

/// A neighbor's states and controls, with the problem's own initial state.
Trajectory guess_from(const NeighbourAnswer& from, const Trajectory& own) {
  Trajectory guess = from.trajectory;
  guess.x(0) = own.x(0);
  return guess;
}

int most_iterations(const NeighbourAnswer& from) {
  constexpr int kUnlimited = std::numeric_limits<int>::max();
  if (from.cold_iterations > kUnlimited / kTrialFactor) return kUnlimited;
  return std::max(kLeastTrial, kTrialFactor * from.cold_iterations);
}

}  // namespace

std::string_view to_string(StartKind kind) {
  constexpr std::string_view kNames[] = {"own", "warm", "dropped"};
  return kNames[static_cast<int>(kind)];
}

std::shared_ptr<const DualGuess> multipliers_of(const SolveResult& result) {
  return std::make_shared<DualGuess>(
      DualGuess{result.constraint_multipliers, result.costates, result.control_gradient});
}

NeighbourAnswer answer_for_neighbours(const StartedSolve& solved, const SolverInfo* solver,
                                      const NeighbourAnswer* from) {
  const SolveResult& result = solved.result;
  const bool cold = from == nullptr || solved.start != StartKind::kWarm;
  return {result.trajectory, multipliers_of(result), solver,
          cold ? result.iterations : from->cold_iterations};
}

StartedSolve solve_from(const NeighbourAnswer* from, const BuiltProblem& built,
                        const std::vector<const SolverInfo*>& candidates,
                        const SolverOptions& options, const SolverInfo*& solver) {
  const ShootingProblem& problem = *built.problem;
  const Trajectory& own = built.guess;
  const auto judged = std::make_shared<LastJudged>();
  if (from == nullptr)
    return {.result = solve(problem, candidates, options, own, solver,
                            certificate_doubt(options, judged, tangent_columns(built))),
            .judged = judged};
  SolverOptions trial = options;
  trial.homotopy = nullptr;
  trial.restarts = {};
  trial.multipliers = from->multipliers;
  trial.max_iterations = std::min(options.max_iterations, most_iterations(*from));
  const std::vector<const SolverInfo*> found(1, from->solver);
  SolveResult warm = solve(problem, from->solver != nullptr ? found : candidates, trial,
                           guess_from(*from, own), solver);
  if (is_success(warm.status)) return {std::move(warm), StartKind::kWarm};
  SolverOptions rest = options;
  rest.max_time_s = std::max(kLeastTime, options.max_time_s - warm.times.total);
  return {solve(problem, candidates, rest, own, solver,
                certificate_doubt(rest, judged, tangent_columns(built))),
          StartKind::kDropped, warm.iterations, judged};
}

}  // namespace conddp
