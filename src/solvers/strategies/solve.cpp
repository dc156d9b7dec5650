#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "base/shared_library.hpp"
#include "ocp/problem/by_name.hpp"
#include "solvers/common/guess.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/strategies/registry.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

/// True if a solve was ended from outside.
bool stopped(SolveStatus status) {
  return status == SolveStatus::time_limit || status == SolveStatus::interrupted;
}

/// True if residuals are far beyond rounding of a motion in SI units.
bool is_far(const Residuals& r) {
  return r.stationarity > tuning::kLargestStationarity || r.gap > tuning::kLargestGap;
}

/// Marks an answer that ended far away as diverged, whatever ended its iterations.
void name_divergence(SolveResult& result) {
  if (!is_far(result.residuals) || result.iterations == 0) return;
  if (is_success(result.status) || stopped(result.status)) return;
  if (result.status == SolveStatus::diverged) return;
  result.message = fmt::format("the iterates diverged; at the end: {}", result.message);
  result.status = SolveStatus::diverged;
}

/// True if a solver failed and no limit ended it.
bool gave_up(SolveStatus status) {
  return !is_success(status) && status != SolveStatus::max_iterations && !stopped(status);
}

/// True if the user has set a limit of iterations.
bool limits_iterations(const SolverOptions& options) {
  return options.max_iterations < SolverOptions().max_iterations;
}

/// Compiled functions that fail return non-finite numbers, and solvers see only these. The message
/// therefore names the functions.
void name_failed_functions(const ShootingProblem& problem, SolveResult& result) {
  if (!gave_up(result.status)) return;
  for (const std::string& name : failed_functions(problem))
    result.message += fmt::format("; the compiled function '{}' reported failure", name);
}

/// A guess for solvers that simulate its controls. Its states influence nothing, not even units.
Trajectory without_states(const ShootingProblem& problem, const Trajectory& guess) {
  Trajectory controls = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k) controls.u(k) = guess.u(k);
  return controls;
}

SolveResult run(const ShootingProblem& problem, const SolverInfo& solver, SolverOptions options,
                const Trajectory& guess, const Doubt& doubt, Objection& objection) {
  check_options(solver, problem, options);
  check_shape(problem, guess);
  options.restarts = {};
  options.homotopy = nullptr;
  if (solver.constraints != ConstraintSupport::all) options.multipliers = nullptr;
  const auto solve_once = [&](const SolverOptions& asked, const Trajectory& from) {
    return solve_scaled(
        problem, asked, solver.open_gaps ? from : without_states(problem, from),
        [&](const ShootingProblem& scaled, const SolverOptions& mine, const Trajectory& guessed) {
          SolveResult answer = solve_with_restoration(
              scaled, mine, guessed, [&](const SolverOptions& own, const Trajectory& start) {
                return solver.run(scaled, own, start);
              });
          name_divergence(answer);
          return answer;
        });
  };
  const bool penalizes = solver.constraints == ConstraintSupport::all && !solver.complementarity;
  const auto solve_from = [&](const SolverOptions& asked, const Trajectory& from) {
    return solve_keeping_guess(asked, from, penalizes, solve_once);
  };
  SolveResult result = solve_answering(problem, options, guess, doubt, objection, solve_from);
  const auto minimize = [&](const ShootingProblem& violation, const Trajectory& from) {
    SolverOptions own;
    own.threads = options.threads;
    own.max_time_s = options.max_time_s;
    own.interrupted = options.interrupted;
    Objection ignored;
    return run(violation, *find_solver("box_fddp"), own, from, doubt, ignored);
  };
  result = confirm_infeasible(problem, options, std::move(result), doubt, solve_from, minimize);
  name_failed_functions(problem, result);
  return result;
}

/// Empty if the solver's library is missing; the answer so far then mentions it.
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

/// True if a later answer is preferable to the first one: it converged, it is cheaper without
/// jumping, its residuals are no longer far off, or it is a least violation.
bool says_more(const SolveResult& later, const Objection& objection, const SolveResult& first) {
  if (is_success(first.status) && is_success(later.status))
    return !objection.jumps &&
           first.cost - later.cost >
               tuning::kMostGain * std::max(std::abs(first.cost), std::abs(later.cost));
  if (is_success(first.status) || is_success(later.status)) return !is_success(first.status);
  return (is_far(first.residuals) && !is_far(later.residuals)) ||
         (later.status == SolveStatus::infeasible && first.status != SolveStatus::infeasible);
}

/// True if a limit or a signal ended a solve and no other may follow. The default iteration limit
/// ends one solver; a lower limit of the user ends all.
bool ends_all(SolveStatus status, const SolverOptions& options) {
  return stopped(status) || (status == SolveStatus::max_iterations && limits_iterations(options));
}

/// Solves with the first solver that converges to an answer without objections, or with one that
/// every solver's answer meets. Otherwise returns the first answer that converged, or else the
/// first answer or a later, preferable one.
SolveResult run_first(const ShootingProblem& problem, SolverList candidates,
                      const SolverOptions& options, const Trajectory& guess, const Doubt& doubt,
                      const SolverInfo*& used) {
  const auto began = std::chrono::steady_clock::now();
  std::optional<SolveResult> first;
  std::vector<Attempt> attempts;
  std::string before;
  for (const SolverInfo* solver : candidates) {
    SolverOptions own = options;
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began;
    if (first) own.max_time_s = std::max(1e-3, options.max_time_s - gone.count());
    Objection objection;
    std::optional<SolveResult> answer =
        run_if_loaded(problem, *solver, own, guess, doubt, objection, first);
    if (!answer) continue;
    SolveResult& result = *answer;
    const SolveStatus status = result.status;
    attempts.push_back(attempt_of(*solver, 0, result, objection));
    if (is_success(status) && (objection.text.empty() || objection.of_problem)) {
      used = solver;
      result.message = before + result.message;
      first = std::move(result);
      break;
    }
    const std::string ended = is_success(status)
                                  ? fmt::format("{} converged after {} iterations, but {}",
                                                solver->name, result.iterations, objection.text)
                                  : fmt::format("{} ended as {} after {} iterations", solver->name,
                                                to_string(status), result.iterations);
    if (!first || says_more(result, objection, *first)) {
      result.message = before + result.message;
      first = std::move(result);
      used = solver;
    } else {
      first->message += "; " + ended;
    }
    before += ended + "; ";
    if (ends_all(status, options)) break;
  }
  for (Attempt& attempt : attempts) attempt.chosen = attempt.solver == used->name;
  first->attempts = std::move(attempts);
  return std::move(*first);
}

/// Solves with these solvers and, if all of several fail, from other guesses. These use the first
/// solver and, if it repeatedly finds the problem infeasible, the last one from guesses farther
/// away.
SolveResult solve_or_restart(const ShootingProblem& problem, SolverList candidates,
                             const SolverOptions& options, const Trajectory& guess,
                             const Doubt& doubt, const SolverInfo*& used) {
  const auto began = std::chrono::steady_clock::now();
  SolveResult result = run_first(problem, candidates, options, guess, doubt, used);
  if (candidates.size() < 2 || is_success(result.status) || ends_all(result.status, options))
    return result;
  for (const auto& [one, spread] : {std::pair(candidates.first(1), tuning::kFarSpread),
                                    {candidates.last(1), tuning::kFartherSpread}}) {
    SolverOptions own = options;
    own.max_time_s -=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    const Solve by_one = [&](const Trajectory& start, const SolverOptions& mine,
                             const SolverInfo*& by) {
      return run_first(problem, one, mine, start, nullptr, by);
    };
    try {
      result = solve_from_elsewhere(problem, own, guess, result, spread, by_one, doubt, used);
    } catch (const LibraryError&) {  // the answer says so already
    }
    if (result.status != SolveStatus::infeasible) break;
  }
  return result;
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
  if (options.restarts.count <= 0 && !options.homotopy)
    return solve_or_restart(problem, candidates, options, guess, doubt, used);
  SolveResult result(problem);
  if (options.restarts.count <= 0) {
    result = once(guess, options, used);
    result.attempts.clear();  // attempts of its last step
    return result;
  }
  const bool concurrent = std::all_of(candidates.begin(), candidates.end(),
                                      [](const SolverInfo* info) { return info->concurrent; });
  result = solve_restarts(problem, options, guess, concurrent ? options.threads : 1, once, used);
  result.attempts.clear();  // attempts of one start
  return result;
}

SolveResult solve_best(const ShootingProblem& problem, SolverList candidates,
                       const SolverOptions& options, const Trajectory& guess,
                       const SolverInfo*& used, const Doubt& doubt) {
  SolveResult result = solve(problem, candidates, options, guess, used, doubt);
  if (!is_success(result.status) || options.homotopy || options.restarts.count > 0) return result;
  const SolveOnce once = [&](const SolverInfo& solver, const SolverOptions& own,
                             const Trajectory& start, Objection& objection) {
    return run(problem, solver, own, start, doubt, objection);
  };
  return look_further(problem, candidates, options, guess, std::move(result), once, used);
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
