#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "base/shared_library.hpp"
#include "ocp/problem/by_name.hpp"
#include "solvers/strategies/answer_objections.hpp"
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
                const Trajectory& guess, const Doubt& doubt, Objection& objection) {
  check_options(solver, problem, options);
  options.restarts = {};
  options.homotopy = nullptr;
  if (solver.constraints != ConstraintSupport::all) options.multipliers = nullptr;
  SolveResult result = solve_answering(
      problem, options, guess, doubt, objection,
      [&](const SolverOptions& asked, const Trajectory& from) {
        return solve_scaled(
            problem, asked, [&](const ShootingProblem& scaled, const SolverOptions& mine) {
              SolveResult answer = solve_with_restoration(
                  scaled, mine, from, [&](const SolverOptions& own, const Trajectory& start) {
                    return solver.run(scaled, own, start);
                  });
              name_divergence(answer);
              return answer;
            });
      });
  name_failed_functions(problem, result);
  return result;
}

/// Nothing, with a word in the answer that there is, where the solver's library is missing.
std::optional<SolveResult> run_if_loaded(const ShootingProblem& problem, const SolverInfo& solver,
                                         const SolverOptions& options, const Trajectory& guess,
                                         const Doubt& doubt, Objection& objection,
                                         std::optional<SolveResult>& so_far) {
  try {
    return run(problem, solver, options, guess, doubt, objection);
  } catch (const LibraryError& error) {
    if (!so_far) throw;
    so_far->message += fmt::format("; {}", error.what());
    return std::nullopt;
  }
}

/// Ends a solve whose violation has not fallen for a while, by the callbacks of its options. They
/// stay the caller's for whom it goes on. Iterates that were nearly feasible once are watched no
/// longer: from there they lower the cost, by way of others with a larger violation.
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
  bool is_over() const { return last_ - since_ >= kPatience && least_ > kNear * first_; }
  /// An end by impatience is the solver's own.
  void name_end(SolveResult& result) const {
    if (result.status != SolveStatus::interrupted || !is_over()) return;
    if (options_.interrupted && options_.interrupted()) return;
    result.status = SolveStatus::line_search_failed;
    result.message = fmt::format("the violation has not fallen for {} iterations: {}", kPatience,
                                 result.message);
  }

 private:
  /// Iterations, what counts as less, and as nearly feasible beside the first violation.
  static constexpr int kPatience = 100;
  static constexpr double kLess = 0.9, kNear = 1e-4;

  void look(const IterationRecord& row) {
    // Rows behind the end are those of the answer, which may be another iterate.
    if (!is_over()) count(row);
    if (options_.on_iteration) options_.on_iteration(row);
  }
  void count(const IterationRecord& row) {
    const double violation = std::max(row.gap, row.constraint);
    if (row.iteration == 0) first_ = violation;
    last_ = row.iteration;
    if (violation < kLess * least_ || violation <= options_.tolerances.constraint) {
      least_ = violation;
      since_ = last_;
    }
  }

  const SolverOptions& options_;
  double first_ = 0, least_ = std::numeric_limits<double>::infinity();
  int last_ = 0, since_ = 0;
};

/// Ipopt's restoration of feasibility goes on for thousands of iterations where there is no way.
bool may_go_on_in_vain(const SolverInfo& solver) { return solver.name == "ipopt"; }

/// Whether a later answer says more than the first one: that it is one, near, or a least violation.
bool says_more(const SolveResult& later, const SolveResult& first) {
  if (is_success(first.status) || is_success(later.status)) return !is_success(first.status);
  return (is_far(first.residuals) && !is_far(later.residuals)) ||
         (later.status == SolveStatus::infeasible && first.status != SolveStatus::infeasible);
}

/// Whether a limit or a signal ended a solve, after which no other one follows. The default limit
/// of iterations ends a solver, a lower one of the user all.
bool ends_all(SolveStatus status, const SolverOptions& options) {
  return stopped(status) || (status == SolveStatus::max_iterations && limits_iterations(options));
}

/// By the first solver that converges to an answer without doubts; else the first answer that
/// converged; else the first one's, or that of a later one where it says more.
SolveResult run_first(const ShootingProblem& problem, SolverList candidates,
                      const SolverOptions& options, const Trajectory& guess, const Doubt& doubt,
                      const SolverInfo*& used) {
  const auto began = std::chrono::steady_clock::now();
  std::optional<SolveResult> first;
  std::string before;
  for (const SolverInfo* solver : candidates) {
    SolverOptions own = options;
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began;
    if (first) own.max_time_s = std::max(1e-3, options.max_time_s - gone.count());
    Impatience impatience(own);
    Objection objection;
    std::optional<SolveResult> answer = run_if_loaded(
        problem, *solver, first && may_go_on_in_vain(*solver) ? impatience.options() : own, guess,
        doubt, objection, first);
    if (!answer) continue;
    SolveResult& result = *answer;
    impatience.name_end(result);
    const SolveStatus status = result.status;
    if (is_success(status) && objection.text.empty()) {
      used = solver;
      result.message = before + result.message;
      return std::move(result);
    }
    const std::string ended = is_success(status)
                                  ? fmt::format("{} converged after {} iterations, but {}",
                                                solver->name, result.iterations, objection.text)
                                  : fmt::format("{} ended as {} after {} iterations", solver->name,
                                                to_string(status), result.iterations);
    if (!first || says_more(result, *first)) {
      result.message = before + result.message;
      first = std::move(result);
      used = solver;
    } else {
      first->message += "; " + ended;
    }
    before += ended + "; ";
    if (ends_all(status, options)) break;
  }
  return std::move(*first);
}

/// By these solvers, and where all of several fail by the first of them from other guesses.
SolveResult solve_or_restart(const ShootingProblem& problem, SolverList candidates,
                             const SolverOptions& options, const Trajectory& guess,
                             const Doubt& doubt, const SolverInfo*& used) {
  const auto began = std::chrono::steady_clock::now();
  SolveResult result = run_first(problem, candidates, options, guess, doubt, used);
  if (candidates.size() < 2 || is_success(result.status) || ends_all(result.status, options))
    return result;
  SolverOptions own = options;
  own.max_time_s -= std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const Solve by_first = [&](const Trajectory& start, const SolverOptions& mine,
                             const SolverInfo*& by) {
    return run_first(problem, candidates.first(1), mine, start, nullptr, by);
  };
  return solve_from_elsewhere(problem, own, guess, std::move(result), by_first, doubt, used);
}

}  // namespace

SolveResult solve(const ShootingProblem& problem, SolverList candidates,
                  const SolverOptions& options, const Trajectory& guess, const SolverInfo*& used,
                  const Doubt& doubt) {
  if (candidates.empty())
    throw std::invalid_argument("no solver supports this problem with these options");
  const SolveByFirst by_first = [&](const ShootingProblem& of, SolverList list,
                                    const SolverOptions& own, const Trajectory& start,
                                    const SolverInfo*& by) {
    return run_first(of, list, own, start, doubt, by);
  };
  const Solve once = [&](const Trajectory& start, const SolverOptions& own, const SolverInfo*& by) {
    return own.homotopy ? solve_homotopy(problem, candidates, own, start, by_first, by)
                        : by_first(problem, candidates, own, start, by);
  };
  if (options.restarts.count <= 0)
    return options.homotopy ? once(guess, options, used)
                            : solve_or_restart(problem, candidates, options, guess, doubt, used);
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
