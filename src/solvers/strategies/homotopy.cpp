#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "solvers/common/tuning.hpp"
#include "solvers/strategies/joined_solves.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

bool is_limit(SolveStatus status) {
  return status == SolveStatus::time_limit || status == SolveStatus::interrupted;
}

/// Start of a solve: its guess, multipliers and first penalty.
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

/// Solves along the homotopy, recorded together.
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

  /// Records a problem that cannot be built.
  void note_impossible(double share) {
    steps_.push_back({.share = share, .status = SolveStatus::infeasible});
  }

  /// Returns the last solve as the overall answer.
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

/// Leads from the problem at s = 0 to that at s = 1, in steps that grow and shrink.
class Walk {
 public:
  Walk(const ShootingProblem& problem, SolverList candidates, const SolverOptions& options,
       const Trajectory& guess, const SolveByFirst& solve, const SolverInfo*& used)
      : problem_(problem),
        candidates_(candidates),
        options_(options),
        used_(used),
        way_(options, solve),
        start_{guess, options.multipliers, options.augmented_lagrangian.initial_penalty} {}

  SolveResult run() {
    if (const auto why = begin()) return solve_directly(*why);
    while (share_ < 1) {
      if (const auto why = advance()) return solve_directly(*why);
    }
    return way_.answer(*std::move(last_));
  }

 private:
  /// Solves the problem at s = 0. Returns the reason if the homotopy cannot continue from there.
  std::optional<std::string> begin() {
    const auto first = options_.homotopy(0);
    if (!first) return "without a start, which cannot be built";
    last_ = way_.attempt(0, *first, candidates_, start_, (options_.max_iterations + 1) / 2, used_);
    if (is_limit(last_->status)) start_.guess = last_->trajectory;
    if (!is_success(last_->status))
      return fmt::format("without a start, which ended as {}", to_string(last_->status));
    quick_ = iterations_ = last_->iterations;
    start_ = start_from(options_, *last_);
    return std::nullopt;
  }

  /// Takes one step, or halves one that fails. Returns the reason if it cannot take another one.
  std::optional<std::string> advance() {
    const double next = std::min(1.0, share_ + step_);
    const SolveStatus status = solve_at(next);
    if (is_success(status)) {
      go_on_from(next);
      return std::nullopt;
    }
    step_ = 0.5 * (next - share_);
    if (is_limit(status) || step_ < tuning::kLeastShareStep || way_.iterations_left() == 0)
      return fmt::format("{} at s = {:.4g}: the step to {:.4g} ended as {}",
                         is_limit(status) ? "stopped" : "stuck", share_, next, to_string(status));
    return std::nullopt;
  }

  /// Solves the problem itself, from the last answer along the way.
  SolveResult solve_directly(const std::string& why) {
    start_.penalty = options_.augmented_lagrangian.initial_penalty;
    SolveResult last =
        way_.attempt(1, problem_, candidates_, start_, way_.iterations_left(), used_);
    last.message = fmt::format("homotopy {}; from there the problem itself: {}", why, last.message);
    return way_.answer(std::move(last));
  }

  /// Solves at a share; a successful answer becomes the last one.
  SolveStatus solve_at(double share) {
    const auto between = options_.homotopy(share);
    if (!between) {
      way_.note_impossible(share);
      return SolveStatus::infeasible;
    }
    const int limit = std::min(std::max(tuning::kLeastLimit, iterations_), way_.iterations_left());
    SolveResult result = way_.attempt(share, share == 1 ? problem_ : *between, std::array{used_},
                                      start_, limit, used_);
    const SolveStatus status = result.status;
    if (is_success(status)) last_ = std::move(result);
    return status;
  }

  void go_on_from(double share) {
    if (last_->iterations <= quick_) step_ *= 2;
    iterations_ += last_->iterations;
    share_ = share;
    start_ = start_from(options_, *last_);
  }

  const ShootingProblem& problem_;
  SolverList candidates_;
  const SolverOptions& options_;
  const SolverInfo*& used_;
  Way way_;
  Start start_;
  std::optional<SolveResult> last_;
  int quick_ = 0;       ///< largest number of iterations of an easy step
  int iterations_ = 0;  ///< iterations of all answers
  double share_ = 0, step_ = tuning::kFirstShare;
};

}  // namespace

SolveResult solve_homotopy(const ShootingProblem& problem, SolverList candidates,
                           const SolverOptions& options, const Trajectory& guess,
                           const SolveByFirst& solve, const SolverInfo*& used) {
  return Walk(problem, candidates, options, guess, solve, used).run();
}

}  // namespace conddp
