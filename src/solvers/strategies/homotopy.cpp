#include "solvers/strategies/homotopy.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "solvers/strategies/joined_solves.hpp"

namespace conddp {
namespace {

constexpr double kFirstStep = 0.25;
constexpr double kShortestStep = 1.0 / 512;
constexpr int kLeastLimit = 50;

bool is_limit(SolveStatus status) {
  return status == SolveStatus::time_limit || status == SolveStatus::interrupted;
}

/// Where a solve begins, and what it may take.
struct Start {
  Trajectory guess;
  std::shared_ptr<const DualGuess> multipliers;
  double penalty;
};

Start start_from(const SolverOptions& options, const SolveResult& last) {
  return {last.trajectory,
          std::make_shared<const DualGuess>(
              DualGuess{last.constraint_multipliers, last.costates, last.control_gradient}),
          next_first_penalty(options, last)};
}

/// The solves on the way, and what they took together.
class Way {
 public:
  Way(const SolverOptions& options, const SolveByFirst& solve) : solve_(solve), solves_(options) {}

  int iterations_left() const { return solves_.iterations_left(); }

  SolveResult attempt(double share, const ShootingProblem& problem, SolverList candidates,
                      const Start& start, int max_iterations, const SolverInfo*& used) {
    SolverOptions own = solves_.next([share](IterationRecord& row) { row.homotopy = share; });
    const double began = solves_.seconds();
    own.homotopy = nullptr;
    own.multipliers = start.multipliers;
    own.augmented_lagrangian.initial_penalty = start.penalty;
    own.max_iterations = max_iterations;
    SolveResult result = solve_(problem, candidates, own, start.guess, used);
    solves_.add(result);
    steps_.push_back(
        {share, result.status, result.iterations, result.cost, solves_.seconds() - began});
    return result;
  }

  /// Of a problem that cannot be built.
  void note_impossible(double share) {
    steps_.push_back({.share = share, .status = SolveStatus::infeasible});
  }

  /// The last solve as the answer of all.
  SolveResult answer(SolveResult last) {
    last = solves_.answer(std::move(last));
    last.homotopy = std::move(steps_);
    return last;
  }

 private:
  const SolveByFirst& solve_;
  JoinedSolves solves_;
  std::vector<HomotopyStep> steps_;
};

}  // namespace

SolveResult solve_homotopy(const ShootingProblem& problem, SolverList candidates,
                           const SolverOptions& options, const Trajectory& guess,
                           const SolveByFirst& solve, const SolverInfo*& used) {
  const double first_penalty = options.augmented_lagrangian.initial_penalty;
  Way way(options, solve);
  Start start{guess, options.multipliers, first_penalty};
  const auto direct = [&](const std::string& why) {
    start.penalty = first_penalty;
    SolveResult last = way.attempt(1, problem, candidates, start, way.iterations_left(), used);
    last.message = fmt::format("homotopy {}; from there the problem itself: {}", why, last.message);
    return way.answer(std::move(last));
  };

  const auto first = options.homotopy(0);
  if (!first) return direct("without a start, which cannot be built");
  SolveResult last =
      way.attempt(0, *first, candidates, start, (options.max_iterations + 1) / 2, used);
  if (is_limit(last.status)) start.guess = last.trajectory;
  if (!is_success(last.status))
    return direct(fmt::format("without a start, which ended as {}", to_string(last.status)));

  const int quick = last.iterations;
  int iterations = last.iterations;  // of answers
  double share = 0, step = kFirstStep;
  start = start_from(options, last);
  while (share < 1) {
    const double next = std::min(1.0, share + step);
    SolveStatus status = SolveStatus::infeasible;
    if (const auto between = options.homotopy(next)) {
      const int limit = std::min(std::max(kLeastLimit, iterations), way.iterations_left());
      SolveResult result =
          way.attempt(next, next == 1 ? problem : *between, std::array{used}, start, limit, used);
      status = result.status;
      if (is_success(status)) last = std::move(result);
    } else {
      way.note_impossible(next);
    }
    if (is_success(status)) {
      if (last.iterations <= quick) step *= 2;
      iterations += last.iterations;
      share = next;
      start = start_from(options, last);
      continue;
    }
    step = 0.5 * (next - share);
    if (is_limit(status) || step < kShortestStep || way.iterations_left() == 0)
      return direct(fmt::format("{} at s = {:.4g}: the step to {:.4g} ended as {}",
                                is_limit(status) ? "stopped" : "stuck", share, next,
                                to_string(status)));
  }
  return way.answer(std::move(last));
}

}  // namespace conddp
