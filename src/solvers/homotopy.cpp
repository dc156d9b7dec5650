#include "solvers/homotopy.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

namespace conddp {
namespace {

constexpr double kFirstStep = 0.25;
constexpr double kShortestStep = 1.0 / 512;
constexpr int kLeastLimit = 50;

bool is_limit(SolveStatus status) {
  return status == SolveStatus::time_limit || status == SolveStatus::interrupted;
}

void add(const SolveTimes& part, SolveTimes& sum) {
  for (double SolveTimes::*time : {&SolveTimes::evaluate, &SolveTimes::differentiate,
                                   &SolveTimes::sweep, &SolveTimes::rollout})
    sum.*time += part.*time;
}

/// The first penalty after an answer: half way, in powers of ten, to the largest one that it
/// needed. The first penalty of all would let go of constraints that its multipliers hold.
double next_penalty(const SolverOptions& options, const SolveResult& last) {
  const auto& augmented = options.augmented_lagrangian;
  const double needed = last.log.empty() ? 0 : last.log.back().constraint_penalty;
  if (!(needed > augmented.initial_penalty)) return augmented.initial_penalty;
  return std::min(std::sqrt(augmented.initial_penalty * needed), augmented.max_penalty);
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
          next_penalty(options, last)};
}

/// The solves on the way, and what they took together.
class Way {
 public:
  Way(const SolverOptions& options, const SolveByFirst& solve) : options_(options), solve_(solve) {}

  int iterations_left() const { return std::max(0, options_.max_iterations - iterations_); }

  SolveResult attempt(double share, const ShootingProblem& problem, SolverList candidates,
                      const Start& start, int max_iterations, const SolverInfo*& used) {
    const double began = seconds();
    SolverOptions own = options_;
    own.homotopy = nullptr;
    own.multipliers = start.multipliers;
    own.augmented_lagrangian.initial_penalty = start.penalty;
    own.max_iterations = max_iterations;
    if (!steps_.empty()) own.max_time_s = std::max(1e-3, options_.max_time_s - began);
    if (options_.interrupted)
      own.interrupted = [this] { return interrupted_ = interrupted_ || options_.interrupted(); };
    if (options_.on_iteration)
      own.on_iteration = [&](const IterationRecord& row) {
        options_.on_iteration(placed(row, share, began));
      };
    SolveResult result = solve_(problem, candidates, own, start.guess, used);
    for (const IterationRecord& row : result.log) log_.push_back(placed(row, share, began));
    if (steps_.empty()) start_ = result.start;
    steps_.push_back({share, result.status, result.iterations, result.cost, seconds() - began});
    iterations_ += result.iterations;
    add(result.times, times_);
    return result;
  }

  /// Of a problem that cannot be built.
  void note_impossible(double share) {
    steps_.push_back({.share = share, .status = SolveStatus::infeasible});
  }

  /// The last solve as the answer of all.
  SolveResult answer(SolveResult last) {
    last.iterations = iterations_;
    last.times = times_;
    last.times.total = seconds();
    last.log = std::move(log_);
    last.start = std::move(start_);
    last.homotopy = std::move(steps_);
    return last;
  }

 private:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }

  IterationRecord placed(IterationRecord row, double share, double began) const {
    row.iteration += iterations_;
    row.time_s += began;
    row.homotopy = share;
    return row;
  }

  const SolverOptions& options_;
  const SolveByFirst& solve_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  bool interrupted_ = false;
  int iterations_ = 0;
  SolveTimes times_;
  std::string start_;
  std::vector<IterationRecord> log_;
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
  if (last.status != SolveStatus::converged)
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
      if (status == SolveStatus::converged) last = std::move(result);
    } else {
      way.note_impossible(next);
    }
    if (status == SolveStatus::converged) {
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
