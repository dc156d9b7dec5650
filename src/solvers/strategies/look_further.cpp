
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <optional>
#include <ranges>
#include <thread>
#include <utility>

#include "base/shared_library.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

/// Estimate of an iteration's time, up to a factor: over all knots, states and controls times the
/// sum of these and the rows of constraints.
double work(const ShootingProblem& problem) {
  double sum = 0;
  for (int k = 0; k < problem.knots(); ++k) {
    const double columns = problem.ndx() + problem.nu(k);
    sum += columns * (columns + problem.knot(k).model->constraint_rows());
  }
  return sum;
}

/// A solve that runs in parallel with others.
struct Trial {
  const SolverInfo* solver = nullptr;
  int start = 0;
  std::optional<SolveResult> result = {};  ///< empty if the solver is not installed
  Objection objection = {};
  std::exception_ptr failure = {};
};

class FurtherLook {
 public:
  FurtherLook(const ShootingProblem& problem, SolverList candidates, const SolverOptions& options,
              const Trajectory& guess, SolveResult found, const SolveOnce& solve,
              const SolverInfo*& used)
      : problem_(problem),
        candidates_(candidates),
        options_(options),
        guess_(guess),
        solve_(solve),
        used_(used),
        most_iterations_(static_cast<int>(options.look_further / work(problem))),
        best_(std::move(found)),
        attempts_(std::exchange(best_.attempts, {})) {
    for (const Attempt& attempt : attempts_) iterations_ += attempt.iterations;
  }

  SolveResult look() {
    std::vector<Trial> others;
    // The last candidate is the least similar to the first.
    for (const SolverInfo* solver : candidates_ | std::views::reverse) others.push_back({solver});
    try_all(std::move(others));
    int start = 0;
    for (const Attempt& attempt : attempts_) start = std::max(start, attempt.start);
    const auto try_next = [&] {
      std::vector<Trial> next;
      for (int i = 0; i < tuning::kBeside; ++i) next.push_back({used_, ++start});
      try_all(std::move(next));
    };
    try_next();
    if (options_.look_further > 0)
      most_iterations_ = std::max(most_iterations_, iterations_ + options_.max_iterations);
    while (chosen().jumps && start < tuning::kTries && may_go_on()) try_next();
    return end();
  }

 private:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }
  double seconds_left() const { return options_.max_time_s - first_seconds_ - seconds(); }
  const Attempt& chosen() const { return *std::ranges::find_if(attempts_, &Attempt::chosen); }
  bool was_made(const Trial& trial) const {
    return std::ranges::any_of(attempts_, [&](const Attempt& a) {
      return a.solver == trial.solver->name && a.start == trial.start;
    });
  }
  bool is_interrupted() {
    const std::lock_guard lock(callback_);
    return interrupted_ = interrupted_ || (options_.interrupted && options_.interrupted());
  }
  bool may_go_on() {
    if (cut_short_ || iterations_ >= most_iterations_) return false;
    cut_short_ = !(seconds_left() > 0) || is_interrupted();
    return !cut_short_;
  }

  /// Runs the trials that were not made yet, in parallel. Their limits are set before the first of
  /// them, so that no answer depends on the number of threads.
  void try_all(std::vector<Trial> trials) {
    std::erase_if(trials, [&](const Trial& trial) { return was_made(trial); });
    if (trials.empty() || !may_go_on()) return;
    const SolverInfo& first = *trials.front().solver;
    const bool alike = trials.size() > 1 && trials.back().solver == &first;
    const int threads = alike && !first.concurrent
                            ? 1
                            : std::min(options_.threads, static_cast<int>(trials.size()));
    const bool jumps = chosen().jumps;
    std::atomic<std::size_t> next = 0;
    const auto work_off = [&] {
      for (std::size_t i = next++; i < trials.size(); i = next++)
        attempt(trials[i], threads, jumps);
    };
    {
      std::vector<std::jthread> workers;
      for (int i = 1; i < threads; ++i) workers.emplace_back(work_off);
      work_off();
    }
    for (Trial& trial : trials) take(trial);
  }

  void attempt(Trial& trial, int threads, bool jumps) {
    SolverOptions own = options_;
    own.on_iteration = nullptr;
    own.interrupted = [this] { return is_interrupted(); };
    if (threads > 1) own.threads = 1;
    own.max_time_s = seconds_left();
    if (!jumps)
      own.max_iterations = std::min(
          own.max_iterations, std::max(tuning::kLeastLimit, tuning::kTimes * best_.iterations));
    const SolverOptions::Restarts far{.seed = options_.restarts.seed, .spread = tuning::kFarSpread};
    try {
      trial.result =
          solve_(*trial.solver, own, start_of(problem_, far, guess_, trial.start), trial.objection);
    } catch (const LibraryError&) {  // a solver that is not installed finds nothing
    } catch (...) {
      trial.failure = std::current_exception();
    }
  }

  void take(Trial& trial) {
    if (trial.failure) std::rethrow_exception(trial.failure);
    if (!trial.result) return;
    SolveResult& result = *trial.result;
    iterations_ += result.iterations;
    cut_short_ = cut_short_ || result.status == SolveStatus::time_limit ||
                 result.status == SolveStatus::interrupted;
    const bool better = is_better(result, trial.objection);
    attempts_.push_back(attempt_of(*trial.solver, trial.start, result, trial.objection));
    if (!better) return;
    for (Attempt& attempt : attempts_) attempt.chosen = &attempt == &attempts_.back();
    best_ = std::move(result);
    used_ = trial.solver;
  }

  bool is_better(const SolveResult& result, const Objection& objection) const {
    if (!is_success(result.status) || objection.jumps) return false;
    if (chosen().jumps) return true;
    const bool doubted = !objection.text.empty(), was_doubted = !chosen().objection.empty();
    if (doubted && !was_doubted) return false;
    const double less = tuning::kMostGain * std::max(std::abs(best_.cost), std::abs(result.cost));
    return best_.cost - result.cost > (was_doubted && !doubted ? -less : less);
  }

  SolveResult end() {
    if (cut_short_) best_.message += "; the search for better answers was cut short";
    best_.times.total = first_seconds_ + seconds();
    best_.attempts = std::move(attempts_);
    return std::move(best_);
  }

  const ShootingProblem& problem_;
  const SolverList candidates_;
  const SolverOptions& options_;
  const Trajectory& guess_;
  const SolveOnce& solve_;
  const SolverInfo*& used_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  int most_iterations_;
  SolveResult best_;
  std::vector<Attempt> attempts_;
  const double first_seconds_ = best_.times.total;
  int iterations_ = 0;
  bool cut_short_ = false;
  std::mutex callback_;
  bool interrupted_ = false;  ///< guarded by `callback_`
};

}  // namespace

SolveResult look_further(const ShootingProblem& problem, SolverList candidates,
                         const SolverOptions& options, const Trajectory& guess, SolveResult found,
                         const SolveOnce& solve, const SolverInfo*& used) {
  return FurtherLook(problem, candidates, options, guess, std::move(found), solve, used).look();
}

}  // namespace conddp
