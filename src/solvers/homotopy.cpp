#include "solvers/homotopy.hpp"

#include <algorithm>
#include <array>
#include <chrono>

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

class Homotopy {
 public:
  Homotopy(const SolverOptions& options, const SolveByFirst& solve)
      : options_(options), solve_(solve) {}

  int left() const { return std::max(0, options_.max_iterations - iterations_); }

  /// A solve, whose rows, iterations and times are added to those before.
  SolveResult attempt(double share, const ShootingProblem& problem, SolverList candidates,
                      const Trajectory& guess, std::shared_ptr<const DualGuess> multipliers,
                      int limit, const SolverInfo*& used) {
    const double began = seconds();
    SolverOptions own = options_;
    own.homotopy = nullptr;
    own.multipliers = std::move(multipliers);
    own.max_iterations = limit;
    if (!steps_.empty()) own.max_time_s = std::max(1e-3, options_.max_time_s - began);
    if (options_.interrupted)
      own.interrupted = [this] { return interrupted_ = interrupted_ || options_.interrupted(); };
    if (options_.on_iteration)
      own.on_iteration = [&](const IterationRecord& row) {
        options_.on_iteration(placed(row, share, began));
      };
    SolveResult result = solve_(problem, candidates, own, guess, used);
    for (const IterationRecord& row : result.log) log_.push_back(placed(row, share, began));
    if (steps_.empty()) start_ = result.start;
    steps_.push_back({share, result.status, result.iterations, result.cost, seconds() - began});
    iterations_ += result.iterations;
    add(result.times, times_);
    return result;
  }

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

std::shared_ptr<const DualGuess> multipliers_of(const SolveResult& result) {
  return std::make_shared<const DualGuess>(
      DualGuess{result.constraint_multipliers, result.costates, result.control_gradient});
}

}  // namespace

SolveResult solve_homotopy(const ShootingProblem& problem, SolverList candidates,
                           const SolverOptions& options, const Trajectory& guess,
                           const SolveByFirst& solve, const SolverInfo*& used) {
  Homotopy homotopy(options, solve);
  Trajectory start = guess;
  std::shared_ptr<const DualGuess> multipliers = options.multipliers;
  std::string stuck = "its start cannot be built";
  if (const auto first = options.homotopy(0)) {
    SolveResult last = homotopy.attempt(0, *first, candidates, start, multipliers,
                                        (options.max_iterations + 1) / 2, used);
    stuck = fmt::format("its start ended as {}", to_string(last.status));
    const int quick = last.iterations;
    int converged = last.iterations;
    double share = 0, step = kFirstStep;
    bool ended = last.status != SolveStatus::converged;
    if (is_limit(last.status)) start = last.trajectory;
    while (!ended) {
      start = last.trajectory;
      multipliers = multipliers_of(last);
      if (share == 1) return homotopy.answer(std::move(last));
      const double next = std::min(1.0, share + step);
      SolveStatus status = SolveStatus::infeasible;
      if (const auto between = options.homotopy(next)) {
        const int limit = std::min(std::max(kLeastLimit, converged), homotopy.left());
        SolveResult result = homotopy.attempt(next, next == 1 ? problem : *between,
                                              std::array{used}, start, multipliers, limit, used);
        status = result.status;
        if (status == SolveStatus::converged) {
          if (result.iterations <= quick) step *= 2;
          converged += result.iterations;
          share = next;
          last = std::move(result);
          continue;
        }
      } else {
        homotopy.note_impossible(next);
      }
      step = 0.5 * (next - share);
      stuck = fmt::format("stuck at s = {:.4g}: the step to {:.4g} ended as {}", share, next,
                          to_string(status));
      ended = is_limit(status) || step < kShortestStep || homotopy.left() == 0;
    }
  }
  SolveResult direct = homotopy.attempt(1, problem, candidates, start, std::move(multipliers),
                                        homotopy.left(), used);
  direct.message =
      fmt::format("homotopy {}; from there the problem itself: {}", stuck, direct.message);
  return homotopy.answer(std::move(direct));
}

}  // namespace conddp
