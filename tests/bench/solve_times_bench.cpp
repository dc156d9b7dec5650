// bench_solve_times FILE [--solver NAME] [--drop NAME]... [--set KEY=VALUE]... [--repeat N]
//
// Solves a problem repeatedly in one process after a warm-up. Prints JSON with the times of each
// run by operation and iteration, the guess, and the answer. scripts/peers/compare compares this
// output with other solvers. Each operation is also timed separately at the answer: all
// derivatives, one sweep, one rollout.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// Minimum number of calls for a median.
constexpr int kEvaluatorRepeat = 50;

struct Arguments {
  std::string file, solver;
  std::vector<std::string> drop, settings;
  int repeat = 25, warm_up = 5;
};

Json json_of(const Trajectory& trajectory) {
  Json x = Json::array(), u = Json::array();
  const auto list = [](const auto& v) { return std::vector<double>(v.begin(), v.end()); };
  for (int k = 0; k <= trajectory.knots(); ++k) x.push_back(list(trajectory.x(k)));
  for (int k = 0; k < trajectory.knots(); ++k) u.push_back(list(trajectory.u(k)));
  return {{"x", x}, {"u", u}};
}

Json json_of(const SolveResult& result) {
  Json log = Json::array();
  for (const IterationRecord& row : result.log)
    log.push_back({{"cost", row.cost},
                   {"gap", row.gap},
                   {"sweeps", row.sweeps},
                   {"trials", row.trials},
                   {"time", row.time_s}});
  return {{"total", result.times.total},
          {"differentiate", result.times.differentiate},
          {"sweep", result.times.sweep},
          {"rollout", result.times.rollout},
          {"log", log}};
}

/// Median time of `repeat` calls in seconds.
template <class F>
double median_time(int repeat, F act) {
  std::vector<double> times;
  for (int i = 0; i < repeat; ++i) {
    const auto began = std::chrono::steady_clock::now();
    act();
    times.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
  }
  const auto middle = times.begin() + repeat / 2;
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

/// Times of the parts of an iteration at an answer: derivatives, the sweep of a DDP solver (with
/// box-constrained stages if controls have bounds), and a full-step rollout.
Json evaluator_times(const ShootingProblem& problem, const SolverOptions& options,
                     const SolveResult& answer, int repeat) {
  Evaluator evaluator(problem, options.threads);
  Linearization linearization(problem);
  evaluator.differentiate(answer.trajectory, linearization);
  Gaps gaps(problem);
  gaps.set(linearization, true);
  const ControlBounds bounds(problem);
  BackwardSweep sweep(problem, bounds);
  const auto policy =
      problem.has_control_bounds() ? box_stage(problem) : unconstrained_stage(problem);
  Feedback feedback(problem);
  SingleRollout rollout(problem);
  const auto differentiate = [&] { evaluator.differentiate(answer.trajectory, linearization); };
  const auto go_back = [&] {
    sweep.run(linearization, answer.trajectory, gaps, {}, *policy, feedback);
  };
  const RolloutOptions closing{.contract_gaps = true,
                               .clamp_controls = problem.has_control_bounds()};
  const auto roll_out = [&] {
    evaluator.roll_out(answer.trajectory, linearization.gap, feedback, 1.0, closing, rollout);
  };
  return {{"differentiate", median_time(repeat, differentiate)},
          {"sweep", median_time(repeat, go_back)},
          {"rollout", median_time(repeat, roll_out)}};
}

int run(const Arguments& arguments) {
  Diagnostics diagnostics;
  auto spec = read_problem(arguments.file, arguments.settings, diagnostics);
  if (spec && !arguments.solver.empty()) spec->solver.name = {arguments.solver, {}};
  const auto built = spec ? build_problem(*spec, {.drop = arguments.drop}, diagnostics)
                          : std::optional<BuiltProblem>();
  const auto candidates =
      built ? usable_solvers(*built, diagnostics) : std::vector<const SolverInfo*>();
  const SolverInfo* solver = candidates.empty() ? nullptr : candidates.front();
  if (solver == nullptr) {
    std::cerr << format_diagnostics(diagnostics, false);
    return 2;
  }
  const ShootingProblem& problem = *built->problem;
  const Trajectory& guess = built->guess;
  Json runs = Json::array();
  for (int i = 0; i < arguments.warm_up; ++i) solve(problem, *solver, spec->solver.options, guess);
  SolveResult last(problem);
  for (int i = 0; i < arguments.repeat; ++i) {
    last = solve(problem, *solver, spec->solver.options, guess);
    runs.push_back(json_of(last));
  }
  const Json out = {
      {"knots", problem.knots()},
      {"solver", solver->name},
      {"status", to_string(last.status)},
      {"cost", last.cost},
      {"iterations", last.iterations},
      {"message", last.message},
      {"guess", json_of(guess)},
      {"answer", json_of(last.trajectory)},
      {"runs", runs},
      {"evaluator", arguments.repeat > 1
                        ? evaluator_times(problem, spec->solver.options, last,
                                          std::max(arguments.repeat, kEvaluatorRepeat))
                        : Json()}};
  std::cout << out.dump() << '\n';
  return 0;
}

}  // namespace
}  // namespace conddp

int main(int argc, char** argv) {
  conddp::Arguments arguments;
  CLI::App app("Times of repeated solves, as JSON");
  app.add_option("FILE", arguments.file, "Problem file")->required();
  app.add_option("--solver", arguments.solver, "Solver instead of the file's");
  app.add_option("--drop", arguments.drop, "Constraint to leave out")->allow_extra_args(false);
  app.add_option("--set", arguments.settings, "KEY=VALUE of the file")->allow_extra_args(false);
  app.add_option("--repeat", arguments.repeat, "Timed runs")->check(CLI::Range(1, 1000000));
  app.add_option("--warm-up", arguments.warm_up, "Runs before them")->check(CLI::Range(0, 1000000));
  CLI11_PARSE(app, argc, argv);
  return conddp::run(arguments);
}
