#include "solvers/strategies/look_further.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ranges>
#include <utility>

#include "base/shared_library.hpp"
#include "solvers/strategies/restarts.hpp"

namespace conddp {
namespace {

/// Of the cost, what a better answer costs less: more than what tolerances leave open.
constexpr double kLess = 1e-4;
/// Perturbed guesses at most (docs/measurements/verdicts.md).
constexpr int kMostStarts = 2;
/// Iterations of an attempt: beside those of the best one, and at least.
constexpr int kTimes = 4, kLeast = 50;

/// To what the time of an iteration is about proportional: over all knots, states and controls
/// times these and the rows of constraints.
double work(const ShootingProblem& problem) {
  double sum = 0;
  for (int k = 0; k < problem.knots(); ++k) {
    const double columns = problem.ndx() + problem.nu(k);
    sum += columns * (columns + problem.knot(k).model->constraint_rows());
  }
  return sum;
}

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
    // The last one is the least like the first.
    for (const SolverInfo* solver : candidates_ | std::views::reverse) attempt(*solver, 0);
    for (int start = 1; start <= kMostStarts; ++start) attempt(*used_, start);
    return end();
  }

 private:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }
  double seconds_left() const { return options_.max_time_s - first_seconds_ - seconds(); }
  bool was_made(const SolverInfo& solver, int start) const {
    return std::ranges::any_of(
        attempts_, [&](const Attempt& a) { return a.solver == solver.name && a.start == start; });
  }
  bool may_go_on() {
    if (cut_short_ || iterations_ >= most_iterations_) return false;
    cut_short_ = !(seconds_left() > 0) || (options_.interrupted && options_.interrupted());
    return !cut_short_;
  }

  void attempt(const SolverInfo& solver, int start) {
    if (was_made(solver, start) || !may_go_on()) return;
    SolverOptions own = options_;
    own.on_iteration = nullptr;
    own.max_time_s = seconds_left();
    own.max_iterations = std::min(own.max_iterations, std::max(kLeast, kTimes * best_.iterations));
    const SolverOptions::Restarts far{.seed = options_.restarts.seed, .spread = kFarSpread};
    Objection objection;
    try {
      take(solver, start, solve_(solver, own, start_of(problem_, far, guess_, start), objection),
           objection);
    } catch (const LibraryError&) {  // a solver that is not installed finds nothing
    }
  }

  void take(const SolverInfo& solver, int start, SolveResult result, const Objection& objection) {
    iterations_ += result.iterations;
    cut_short_ =
        result.status == SolveStatus::time_limit || result.status == SolveStatus::interrupted;
    const bool better = is_better(result, objection);
    attempts_.push_back(attempt_of(solver, start, result, objection.text));
    if (!better) return;
    for (Attempt& attempt : attempts_) attempt.chosen = &attempt == &attempts_.back();
    best_ = std::move(result);
    used_ = &solver;
  }

  bool is_better(const SolveResult& result, const Objection& objection) const {
    if (!is_success(result.status) || !objection.text.empty()) return false;
    const auto chosen = std::ranges::find_if(attempts_, &Attempt::chosen);
    if (!chosen->objection.empty()) return true;
    return best_.cost - result.cost > kLess * std::max(std::abs(best_.cost), std::abs(result.cost));
  }

  SolveResult end() {
    if (cut_short_) best_.message += "; a look for better answers was cut short";
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
  const int most_iterations_;
  SolveResult best_;
  std::vector<Attempt> attempts_;
  const double first_seconds_ = best_.times.total;
  int iterations_ = 0;
  bool cut_short_ = false;
};

}  // namespace

SolveResult look_further(const ShootingProblem& problem, SolverList candidates,
                         const SolverOptions& options, const Trajectory& guess, SolveResult found,
                         const SolveOnce& solve, const SolverInfo*& used) {
  return FurtherLook(problem, candidates, options, guess, std::move(found), solve, used).look();
}

}  // namespace conddp
