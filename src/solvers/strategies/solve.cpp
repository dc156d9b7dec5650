#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "base/shared_library.hpp"
#include "ocp/problem/by_name.hpp"
#include "solvers/strategies/homotopy.hpp"
#include "solvers/strategies/option_check.hpp"
#include "solvers/strategies/registry.hpp"
#include "solvers/strategies/restarts.hpp"
#include "solvers/strategies/restoration.hpp"
#include "solvers/strategies/scaled_solve.hpp"

namespace conddp {
namespace {

/// Residuals of answers that have diverged are larger: of a gradient, and of a gap.
constexpr double kLargestStationarity = 1e16, kLargestGap = 1e10;

/// Whether a solve ended from outside.
bool stopped(SolveStatus status) {
  return status == SolveStatus::time_limit || status == SolveStatus::interrupted;
}

/// Whether residuals are far beyond what rounding leaves of a motion in SI units.
bool is_far(const Residuals& r) {
  return r.stationarity > kLargestStationarity || r.gap > kLargestGap;
}

/// An answer that ended far away has diverged, whatever ended its iterations.
void name_divergence(SolveResult& result) {
  if (!is_far(result.residuals) || result.iterations == 0) return;
  if (is_success(result.status) || stopped(result.status)) return;
  if (result.status == SolveStatus::diverged) return;
  result.message = fmt::format("the iterates diverged; at the end: {}", result.message);
  result.status = SolveStatus::diverged;
}

/// Whether a solver gave up, and no limit ended it.
bool gave_up(SolveStatus status) {
  return !is_success(status) && status != SolveStatus::max_iterations && !stopped(status);
}

/// Whether there is a limit of iterations that the user has set.
bool limits_iterations(const SolverOptions& options) {
  return options.max_iterations < SolverOptions().max_iterations;
}

/// Compiled functions that report failure give numbers that are not finite, which is all that
/// solvers see of that.
void name_failed_functions(const ShootingProblem& problem, SolveResult& result) {
  if (!gave_up(result.status)) return;
  for (const std::string& name : failed_functions(problem))
    result.message += fmt::format("; the compiled function '{}' reported failure", name);
}

SolveResult run(const ShootingProblem& problem, const SolverInfo& solver, SolverOptions options,
                const Trajectory& guess) {
  check_options(solver, problem, options);
  options.restarts = {};
  options.homotopy = nullptr;
  if (solver.constraints != ConstraintSupport::all) options.multipliers = nullptr;
  SolveResult result =
      solve_scaled(problem, options, [&](const ShootingProblem& scaled, const SolverOptions& mine) {
        SolveResult answer = solve_with_restoration(
            scaled, mine, guess, [&](const SolverOptions& own, const Trajectory& start) {
              return solver.run(scaled, own, start);
            });
        name_divergence(answer);
        return answer;
      });
  name_failed_functions(problem, result);
  return result;
}

/// Nothing, with a word in the answer that there is, where the solver's library is missing.
std::optional<SolveResult> run_if_loaded(const ShootingProblem& problem, const SolverInfo& solver,
                                         const SolverOptions& options, const Trajectory& guess,
                                         std::optional<SolveResult>& so_far) {
  try {
    return run(problem, solver, options, guess);
  } catch (const LibraryError& error) {
    if (!so_far) throw;
    so_far->message += fmt::format("; {}", error.what());
    return std::nullopt;
  }
}

/// Ends a solve whose violation has not fallen for a while, by the callbacks of its options. They
/// stay the caller's for whom it goes on.
class Impatience {
 public:
  explicit Impatience(const SolverOptions& options) : options_(options) {}

  SolverOptions options() {
    SolverOptions own = options_;
    own.on_iteration = [this](const IterationRecord& row) { look(row); };
    own.interrupted = [this] {
      return is_over() || (options_.interrupted && options_.interrupted());
    };
    return own;
  }
  bool is_over() const { return last_ - since_ >= kPatience; }
  /// An end by impatience is the solver's own.
  void name_end(SolveResult& result) const {
    if (result.status != SolveStatus::interrupted || !is_over()) return;
    if (options_.interrupted && options_.interrupted()) return;
    result.status = SolveStatus::line_search_failed;
    result.message = fmt::format("the violation has not fallen for {} iterations: {}", kPatience,
                                 result.message);
  }

 private:
  /// Iterations, and what counts as less.
  static constexpr int kPatience = 100;
  static constexpr double kLess = 0.9;

  void look(const IterationRecord& row) {
    const double violation = std::max(row.gap, row.constraint);
    last_ = row.iteration;
    if (violation < kLess * least_ || violation <= options_.tolerances.constraint) {
      least_ = violation;
      since_ = last_;
    }
    if (options_.on_iteration) options_.on_iteration(row);
  }

  const SolverOptions& options_;
  double least_ = std::numeric_limits<double>::infinity();
  int last_ = 0, since_ = 0;
};

/// Ipopt's restoration of feasibility goes on for thousands of iterations where there is no way.
bool may_go_on_in_vain(const SolverInfo& solver) { return solver.name == "ipopt"; }

/// Whether a later answer says more than the first one: that it is near, or a least violation.
bool says_more(const SolveResult& later, const SolveResult& first) {
  return (is_far(first.residuals) && !is_far(later.residuals)) ||
         (later.status == SolveStatus::infeasible && first.status != SolveStatus::infeasible);
}

/// By the first solver that converges; else the first one's answer, or that of a later one where it
/// says more. The default limit of iterations ends a solver, a lower one of the user all.
SolveResult run_first(const ShootingProblem& problem, SolverList candidates,
                      const SolverOptions& options, const Trajectory& guess,
                      const SolverInfo*& used) {
  const auto began = std::chrono::steady_clock::now();
  std::optional<SolveResult> first;
  std::string before;
  for (const SolverInfo* solver : candidates) {
    SolverOptions own = options;
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began;
    if (first) own.max_time_s = std::max(1e-3, options.max_time_s - gone.count());
    Impatience impatience(own);
    std::optional<SolveResult> answer = run_if_loaded(
        problem, *solver, first && may_go_on_in_vain(*solver) ? impatience.options() : own, guess,
        first);
    if (!answer) continue;
    SolveResult& result = *answer;
    impatience.name_end(result);
    const SolveStatus status = result.status;
    if (is_success(status) || !first) used = solver;
    if (is_success(status)) {
      result.message = before + result.message;
      return std::move(result);
    }
    const std::string ended = fmt::format("{} ended as {} after {} iterations", solver->name,
                                          to_string(status), result.iterations);
    before += ended + "; ";
    if (!first) {
      first = std::move(result);
    } else if (says_more(result, *first)) {
      result.message = before + result.message;
      first = std::move(result);
      used = solver;
    } else {
      first->message += "; " + ended;
    }
    if (stopped(status) || (status == SolveStatus::max_iterations && limits_iterations(options)))
      break;
  }
  return std::move(*first);
}

}  // namespace

SolveResult solve(const ShootingProblem& problem, SolverList candidates,
                  const SolverOptions& options, const Trajectory& guess, const SolverInfo*& used) {
  if (candidates.empty())
    throw std::invalid_argument("no solver supports this problem with these options");
  const Solve once = [&](const Trajectory& start, const SolverOptions& own, const SolverInfo*& by) {
    return own.homotopy ? solve_homotopy(problem, candidates, own, start, run_first, by)
                        : run_first(problem, candidates, own, start, by);
  };
  if (options.restarts.count <= 0) return once(guess, options, used);
  const bool concurrent = std::all_of(candidates.begin(), candidates.end(),
                                      [](const SolverInfo* info) { return info->concurrent; });
  return solve_restarts(problem, options, guess, concurrent ? options.threads : 1, once, used);
}

SolveResult solve(const ShootingProblem& problem, const SolverInfo& solver,
                  const SolverOptions& options, const Trajectory& guess) {
  const SolverInfo* used = nullptr;
  return solve(problem, std::array{&solver}, options, guess, used);
}

SolveResult solve(const ShootingProblem& problem, std::string_view solver,
                  const SolverOptions& options, const Trajectory& guess) {
  if (solver == kAutoSolver) {
    const SolverInfo* used = nullptr;
    return solve(problem, auto_solvers(problem, options), options, guess, used);
  }
  const SolverInfo* info = find_solver(solver);
  if (info == nullptr) throw std::invalid_argument(fmt::format("unknown solver '{}'", solver));
  return solve(problem, *info, options, guess);
}

}  // namespace conddp
