#include "analysis/comparison/benchmark.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "ocp/problem/cost_scale.hpp"

namespace conddp {
namespace {

/// Tolerances apply to the scaled costs.
bool agrees(const AnswerCheck& check, const SolverOptions& options, double scale) {
  const auto& tolerance = options.tolerances;
  return scale * check.stationarity <= kCheckFactor * tolerance.stationarity &&
         check.gap <= kCheckFactor * tolerance.gap &&
         check.constraint <= kCheckFactor * tolerance.constraint;
}

SolveTimes medians(const std::vector<SolveTimes>& all) {
  const auto middle = [&](double SolveTimes::*part) {
    std::vector<double> values;
    for (const SolveTimes& times : all) values.push_back(times.*part);
    return median(std::move(values));
  };
  return {.total = middle(&SolveTimes::total),
          .evaluate = middle(&SolveTimes::evaluate),
          .differentiate = middle(&SolveTimes::differentiate),
          .sweep = middle(&SolveTimes::sweep),
          .rollout = middle(&SolveTimes::rollout)};
}

/// Skips row 0 of the log, which is the guess.
int sweeps(const std::vector<IterationRecord>& log) {
  int sum = 0;
  for (std::size_t i = 1; i < log.size(); ++i) sum += std::max(log[i].sweeps, 1);
  return sum;
}

/// Reason why an answer does not count as converged.
std::string contradiction(const AnswerCheck& check) {
  return fmt::format(
      "called converged, but the check finds stationarity {:.1e}, gap {:.1e}, constraint {:.1e}",
      check.stationarity, check.gap, check.constraint);
}

/// Records the claims of a solve about its answer, and the result of the check.
void describe(const SolveResult& result, const ShootingProblem& problem,
              const SolverOptions& options, BenchmarkRun& run) {
  run.status = to_string(result.status);
  run.message = result.message;
  run.iterations = result.iterations;
  run.sweeps = sweeps(result.log);
  run.claimed = result.residuals;
  run.check = check_answer(problem, result.trajectory, options.tolerances.constraint,
                           result.constraint_multipliers);
  run.solved =
      result.status == SolveStatus::converged && agrees(run.check, options, cost_scale(problem));
  if (!run.kept_word()) run.message = contradiction(run.check);
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double BenchmarkRun::spread() const {
  if (times.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto [smallest, largest] = std::minmax_element(times.begin(), times.end());
  return (*largest - *smallest) / median.total;
}

namespace {

/// True if another solve would take as long, and not too long.
bool is_repeatable(const SolveResult& result, const Repetition& repetition) {
  return result.status != SolveStatus::time_limit && result.status != SolveStatus::interrupted &&
         !(result.times.total > repetition.longest_s);
}

}  // namespace

BenchmarkRun run_benchmark(const ShootingProblem& problem, const Trajectory& guess,
                           std::string_view name, SolverList solvers, const SolverOptions& options,
                           const Repetition& repetition, Trajectory* answer) {
  BenchmarkRun run{.solver = std::string(name)};
  const SolverInfo* used = nullptr;
  int repeat = repetition.count;
  std::vector<SolveTimes> times;
  try {
    const SolveResult result = solve(problem, solvers, options, guess, used);
    describe(result, problem, options, run);
    if (answer != nullptr) *answer = result.trajectory;
    if (!is_repeatable(result, repetition)) repeat = 0;
    if (repeat == 0) times.push_back(result.times);
  } catch (const std::invalid_argument& refusal) {
    run.status = "refused";
    run.message = refusal.what();
    return run;
  }
  for (int i = 0; i < repeat; ++i)
    times.push_back(solve(problem, solvers, options, guess, used).times);
  run.median = medians(times);
  for (const SolveTimes& time : times) run.times.push_back(time.total);
  return run;
}

BenchmarkRun run_benchmark(const ShootingProblem& problem, const Trajectory& guess,
                           std::string_view solver, const SolverOptions& options,
                           const Repetition& repetition, Trajectory* answer) {
  if (solver == kAutoSolver)
    return run_benchmark(problem, guess, solver, auto_solvers(problem, options), options,
                         repetition, answer);
  const SolverInfo* info = find_solver(solver);
  if (info == nullptr)
    return {.solver = std::string(solver),
            .status = "refused",
            .message = fmt::format("unknown solver '{}'", solver)};
  return run_benchmark(problem, guess, solver, std::array{info}, options, repetition, answer);
}

}  // namespace conddp
