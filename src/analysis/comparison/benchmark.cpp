#include "analysis/comparison/benchmark.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "analysis/certificate/lagrangian_gradient.hpp"
#include "analysis/derivatives/node_models.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {
namespace {

double bound_violation(const ShootingProblem& problem, const Trajectory& trajectory) {
  double worst = 0;
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    for (int i = 0; i < problem.nu(k); ++i) {
      const double u = trajectory.u(k)[i];
      worst = std::max({worst, model.control_lower()[i] - u, u - model.control_upper()[i]});
    }
  }
  return worst;
}

bool is_finite(const Linearization& linearization) {
  const auto finite = [](const KnotLinearization& knot) {
    return knot.gradient.allFinite() && knot.hessian().allFinite() && knot.F.allFinite();
  };
  return linearization.cost.allFinite() && linearization.gap.allFinite() &&
         std::all_of(linearization.knots.begin(), linearization.knots.end(), finite);
}

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

AnswerCheck check_answer(const ShootingProblem& problem, const Trajectory& trajectory,
                         double bound_tolerance, const Eigen::VectorXd& constraint_multipliers) {
  AnswerCheck check;
  Evaluator evaluator(problem);
  Linearization linearization(problem);
  Augmentation lagrangian(problem);
  const bool multipliers_known = constraint_multipliers.size() == problem.constraint_rows();
  if (multipliers_known) lagrangian.multiplier = constraint_multipliers;
  evaluator.differentiate(trajectory, linearization, &lagrangian);
  if (!is_finite(linearization)) return check;
  check.cost = linearization.total_cost() + linear_soft_cost(problem, linearization.constraint);
  Eigen::VectorXd start(problem.ndx());
  problem.manifold().difference(problem.initial_state().data(), trajectory.x(0).data(),
                                start.data());
  check.gap = std::max(linearization.max_gap(), start.lpNorm<Eigen::Infinity>());
  check.constraint = bound_violation(problem, trajectory);
  for (const ConstraintViolation& violation : violations_by_name(problem, linearization.constraint))
    check.constraint = std::max(check.constraint, violation.value);
  if (!multipliers_known) return check;
  // The linearization above includes the multiplier terms of constraints.
  const NodeModels models =
      problem.constraint_rows() == 0
          ? confirmed_models(problem, trajectory, linearization.gap, linearization)
          : node_models(problem, trajectory, linearization.gap);
  const RiccatiPolicy policy =
      riccati_policy(problem, trajectory, models.derivatives, models.hessians, bound_tolerance);
  const ProjectedGradient gradient =
      project(problem, trajectory,
              adjoint_pass(problem, models.derivatives, constraint_multipliers, policy.K).control,
              bound_tolerance);
  check.stationarity = gradient.stationarity;
  check.complementarity = gradient.product;
  for (const NodeConstraint& c : problem.constraints())
    check.complementarity =
        std::max(check.complementarity, complementarity(c, linearization.constraint.data() + c.row,
                                                        constraint_multipliers.data() + c.row));
  return check;
}

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

double PerformanceProfile::share(double tau) const {
  double value = 0;
  for (const auto& [ratio, share] : steps)
    if (ratio <= tau) value = share;
  return value;
}

namespace {

/// For each number, the share of `problems` with a number that is not larger.
std::vector<std::pair<double, double>> share_steps(std::vector<double> numbers,
                                                   std::size_t problems) {
  std::sort(numbers.begin(), numbers.end());
  std::vector<std::pair<double, double>> steps;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i + 1 < numbers.size() && numbers[i + 1] == numbers[i]) continue;
    steps.emplace_back(numbers[i], static_cast<double>(i + 1) / static_cast<double>(problems));
  }
  return steps;
}

}  // namespace

std::vector<PerformanceProfile> performance_profiles(
    const std::vector<std::string>& solvers, const std::vector<std::vector<double>>& effort) {
  std::vector<PerformanceProfile> profiles;
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    std::vector<double> ratios;
    for (const std::vector<double>& of_problem : effort) {
      const double best = *std::min_element(of_problem.begin(), of_problem.end());
      if (!std::isfinite(of_problem[s])) continue;
      ratios.push_back(best > 0 ? of_problem[s] / best : 1 + of_problem[s]);
    }
    profiles.push_back(
        {.solver = solvers[s], .steps = share_steps(std::move(ratios), effort.size())});
  }
  return profiles;
}

std::vector<PerformanceProfile> data_profiles(const std::vector<std::string>& solvers,
                                              const std::vector<std::vector<double>>& effort) {
  std::vector<PerformanceProfile> profiles;
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    std::vector<double> needed;
    for (const std::vector<double>& of_problem : effort)
      if (std::isfinite(of_problem[s])) needed.push_back(of_problem[s]);
    profiles.push_back(
        {.solver = solvers[s], .steps = share_steps(std::move(needed), effort.size())});
  }
  return profiles;
}

}  // namespace conddp
