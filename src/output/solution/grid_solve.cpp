#include "output/solution/grid_solve.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/contact/simulated_contacts.hpp"
#include "analysis/findings/findings.hpp"
#include "ocp/knot/knot_model.hpp"
#include "problem_file/assemble/homotopy.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

/// Limits of `auto`: the knots of a detour, relative to the file's, and the number of times that
/// the knots are halved for a guess.
constexpr int kMostKnots = 4, kMostHalvings = 2;
/// The maximum value of the option: the first detour is rarely good.
constexpr int kLargestWork = 1'000'000'000;

/// Measured time of the derivatives of all knots, s: the time of a full batch of the first knot of
/// each phase, times the number of batches.
double differentiation_time(const ShootingProblem& problem, const Trajectory& guess) {
  double seconds = 0;
  int k = 0;
  for (const Phase& phase : problem.phases()) {
    KnotBatch<Lane> batch(*phase.model);
    std::copy_n(guess.x(k).data(), phase.model->nx(), batch.x.begin());
    std::copy_n(guess.u(k).data(), phase.model->nu(), batch.u.begin());
    std::copy_n(phase.parameters.data(), phase.model->parameter_count(), batch.parameters.begin());
    batch.dt = phase.dt.front();
    batch.cost_scale = phase.cost_scale.front();
    const auto began = std::chrono::steady_clock::now();
    phase.model->differentiate(batch.input(), batch.work, true);
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began;
    seconds += gone.count() * ((phase.knots() + kLaneWidth - 1) / kLaneWidth);
    k += phase.knots();
  }
  return seconds;
}

/// Uses the answer on another grid as the guess.
void start_from(const SolveTask& former, const SolveResult& answer, SolveTask& task) {
  task.built.guess = on_grid(*former.built.problem, answer.trajectory, *task.built.problem);
  task.built.guess_used = former.built.guess_used;
}

std::vector<Finding> jumps_of(const SolveTask& task, const SolveResult& result) {
  if (!is_success(result.status)) return {};
  return find_jumps(*task.built.problem, result.trajectory);
}

bool is_stopped(SolveStatus status) {
  return status == SolveStatus::time_limit || status == SolveStatus::interrupted;
}

}  // namespace

double finishing_time(const BuiltProblem& built, bool certified) {
  if (!std::isfinite(built.facts().solver.options.max_time_s)) return 0;
  const ShootingProblem& problem = *built.problem;
  constexpr double kWrittenNumber = 4e-7, kComparedNumber = 5e-7, kEvaluatedKnot = 5e-6;
  constexpr double kDifferentiations = 4;
  double numbers = 0;
  for (int k = 0; k < problem.knots(); ++k)
    numbers += problem.nx() + 2 * problem.ndx() + problem.nu(k) * (problem.ndx() + 2.0);
  const double written = kWrittenNumber * numbers;
  if (!certified) return written;
  return written + kComparedNumber * numbers + kEvaluatedKnot * problem.knots() +
         kDifferentiations * differentiation_time(problem, built.guess);
}

std::optional<SolveResult> GridSolve::run(Diagnostics& out) {
  SolveResult result = solve(task_, true);
  if (task_.built.facts().mesh) return refine(std::move(result), out);
  if (task_.asked().name.value != kAutoSolver || !with_.verify ||
      task_.asked().options.look_further == 0)
    return result;
  if (!jumps_of(task_, result).empty()) return solve_around(std::move(result));
  if (!is_given_up(result.status)) return result;
  if (auto other = solve_from_simulation(result)) return other;
  return climb(task_, std::move(result), 1);
}

std::vector<std::string> GridSolve::with_grid(std::vector<std::string> settings) const {
  if (!rounds_.empty())
    settings.push_back(grid_setting(task_.built, rounds_.back().factor));
  else if (!task_.grid.empty())
    settings.push_back(task_.grid);
  return settings;
}

/// The time limit may only leave time to evaluate the guess.
SolveResult GridSolve::solve(const SolveTask& task, bool first_grid) {
  return solve(task, first_grid, task.asked().options);
}

SolveResult GridSolve::solve(const SolveTask& task, bool first_grid, SolverOptions options) {
  const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - with_.began;
  options.max_time_s = std::max(1e-3, options.max_time_s - gone.count() - task.finishing);
  if (first_grid) {
    options.multipliers = task.built.multipliers;
    options.homotopy = homotopy_path(task.built);
  } else {
    options.restarts.count = 0;
  }
  const Doubt doubt = doubt_of(task, options);
  const std::shared_ptr<void> kept = with_.watch ? with_.watch(options) : nullptr;
  const ShootingProblem& problem = *task.built.problem;
  const bool looks_further = first_grid && task.asked().name.value == kAutoSolver;
  SolveResult result =
      looks_further
          ? solve_best(problem, task.candidates, options, task.built.guess, solver_, doubt)
          : conddp::solve(problem, task.candidates, options, task.built.guess, solver_, doubt);
  seconds_ += result.times.total;
  return result;
}

/// Objections of the certificate; `auto` also objects to motions that jump through what they should
/// go around.
Doubt GridSolve::doubt_of(const SolveTask& task, const SolverOptions& options) const {
  if (!with_.verify) return nullptr;
  Doubt doubt = certificate_doubt(options, task.judged, tangent_columns(task.built));
  if (task.asked().name.value != kAutoSolver) return doubt;
  return [doubt](const ShootingProblem& problem, const SolveResult& result) {
    Objection objection = doubt(problem, result);
    const auto jumps = find_jumps(problem, result.trajectory);
    objection.jumps = !jumps.empty();
    if (objection.text.empty() && objection.jumps) objection.text = jumps.front().message;
    return objection;
  };
}

/// The task on another grid; empty with errors if that grid cannot be built.
std::optional<SolveTask> GridSolve::on_other_grid(const SolveTask& task, const OtherGrid& grid,
                                                  Diagnostics& out) const {
  auto built = build_on_grid(task.built, grid, out);
  if (!built) return std::nullopt;
  SolveTask other{.built = *std::move(built), .candidates = task.candidates};
  other.finishing = finishing_time(other.built, with_.verify);
  other.grid = grid_setting(task.built, grid.factor);
  return other;
}

std::optional<SolveResult> GridSolve::refine(SolveResult result, Diagnostics& out) {
  MeshRefinement mesh(*task_.built.facts().mesh);
  while (const auto factor = mesh.next(*task_.built.problem, result)) {
    auto finer = on_other_grid(task_, {.factor = *factor, .from_answer = true}, out);
    if (!finer) return std::nullopt;
    start_from(task_, result, *finer);
    task_ = *std::move(finer);
    result = solve(task_, false, options_near(task_.asked().options));
  }
  rounds_ = mesh.rounds();
  return result;
}

/// The first answer on a finer grid without jumps, else the former answer.
SolveResult GridSolve::solve_around(SolveResult former) {
  const SolverInfo* const solver = solver_;
  for (int factor = 2; factor <= kMostKnots; factor *= 2) {
    Diagnostics ignored;
    auto finer = on_other_grid(task_, {.factor = factor}, ignored);
    if (!finer) break;
    SolverOptions options = finer->asked().options;
    options.look_further = kLargestWork;
    SolveResult result = solve(*finer, true, options);
    if (is_stopped(result.status)) break;
    if (!is_success(result.status) || !jumps_of(*finer, result).empty()) continue;
    result.message += fmt::format(
        "; on a grid {} times as fine as the file's, on which all answers jump through '{}'",
        factor, jumps_of(task_, former).front().subject);
    result.times.total = seconds_;
    task_ = *std::move(finer);
    return result;
  }
  solver_ = solver;
  return former;
}

/// True if all solvers ended without a statement about the problem.
bool GridSolve::is_given_up(SolveStatus status) const {
  return !is_success(status) && !is_stopped(status) && status != SolveStatus::infeasible &&
         task_.asked().options.max_iterations >= SolverOptions().max_iterations;
}

/// The answer started from a simulation of the guess's controls, with its contacts; empty if the
/// simulation or the solve fails.
std::optional<SolveResult> GridSolve::solve_from_simulation(const SolveResult& failed) {
  auto simulated = simulated_guess(*task_.built.problem, task_.built.guess);
  if (!simulated) return std::nullopt;
  const SolverInfo* const solver = solver_;
  std::swap(task_.built.guess, *simulated);
  SolveResult result = solve(task_, false, options_near(task_.asked().options));
  result.times.total = seconds_;
  if (is_success(result.status)) {
    result.message += fmt::format("; from a simulation of the guess's controls, after {}",
                                  to_string(failed.status));
    return result;
  }
  std::swap(task_.built.guess, *simulated);
  solver_ = solver;
  return std::nullopt;
}

/// The answer started from the answer with the knots of the file halved this often, which may
/// itself start from half of those; `failed` without such an answer.
SolveResult GridSolve::climb(SolveTask& task, SolveResult failed, int halvings) {
  const SolverInfo* const solver = solver_;
  Diagnostics ignored;
  auto coarse = on_other_grid(task, {.halvings = halvings}, ignored);
  if (!coarse) return failed;
  SolveResult below = solve(*coarse, false);
  if (is_given_up(below.status) && halvings < kMostHalvings)
    below = climb(*coarse, std::move(below), halvings + 1);
  solver_ = solver;
  if (!is_success(below.status)) return failed;
  const Trajectory guess = task.built.guess;
  start_from(*coarse, below, task);
  SolveResult result = solve(task, false, options_near(task.asked().options));
  result.times.total = seconds_;
  if (is_success(result.status)) {
    result.message += fmt::format("; from the answer with {} knots, where all solvers failed",
                                  coarse->built.problem->knots());
    return result;
  }
  task.built.guess = guess;
  solver_ = solver;
  failed.times.total = seconds_;
  return failed;
}

}  // namespace conddp
